// Appearance hints of an authored scene: the colours that its parts have in the views.
#ifndef PHYSMAS_BUNDLE_COLOR_HINTS_H
#define PHYSMAS_BUNDLE_COLOR_HINTS_H

#include <cstdint>
#include <vector>

#include "records/inventory.h"
#include "records/run_specification.h"
#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::bundle {

// Gives every row the colours, at most twelve, that cover nearly all of the pixels in which it is in front. As a person
// with a colour picker would, it reads the views and not the Gaussians: glass tints what is behind it.
// row: [N] true row of every Gaussian. A row that no camera sees keeps no hints.
void add_color_hints(const Gaussians& gaussians, const std::vector<int32_t>& row, const std::vector<Camera>& cameras,
                     const RunSpecification::Render& render, Inventory& inventory);

}  // namespace physmas::bundle

#endif
