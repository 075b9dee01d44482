// Masks that can hardly be right: kept, because the labels degrade gracefully, and said.
#ifndef PHYSMAS_MASKS_MASK_DOUBTS_H
#define PHYSMAS_MASKS_MASK_DOUBTS_H

#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "records/provenance.h"

namespace physmas::masks {

// Two objects whose masks share more than this of their union are one thing, or one of the masks is wrong.
constexpr double kSameMask = 0.95;
// A part of which more than this lies outside its object is another object's, or the object's mask is wrong.
constexpr double kOutside = 0.5;

// Of one view: masks that cover the whole image, two objects with one mask, parts that lie outside their object.
std::vector<Omission> doubts_about(const Inventory& inventory, const ViewMasks& view);

}  // namespace physmas::masks

#endif
