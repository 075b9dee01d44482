// What the material models see of a row: the highlighted multi-view sheet and the crops.
#ifndef PHYSMAS_MATERIAL_PICTURES_H
#define PHYSMAS_MATERIAL_PICTURES_H

#include <string>
#include <vector>

#include "records/masks.h"
#include "scene/image.h"
#include "scene/view_pictures.h"

namespace physmas::material {

// Every view in a grid of two columns with its name below: the masked row in its own colours inside a magenta outline,
// the rest dimmed. masks: [views], empty where the view does not show the row; of its view's size otherwise.
Image highlighted_sheet(const std::vector<ViewPicture>& views, const std::vector<const Mask*>& masks);

// The mask's bounding box with a margin of a tenth of its longer side, white outside the mask, at most 512 pixels wide
// and high. The mask must not be empty.
Image masked_crop(const ViewPicture& view, const Mask& mask);

// Pixels inside any of the masks; empty when they all are.
Mask union_of(const std::vector<Mask>& masks);

}  // namespace physmas::material

#endif
