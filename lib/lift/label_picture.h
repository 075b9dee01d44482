// Pictures for looking: which row every Gaussian got.
#ifndef PHYSMAS_LIFT_LABEL_PICTURE_H
#define PHYSMAS_LIFT_LABEL_PICTURE_H

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "scene/image.h"

namespace physmas::lift {

// The scene drawn with every Gaussian in its row's colour; shading keeps a little of the scene's own lightness.
// row: [N]; rows: how many there are. Residual rows (residual[r]) are grey.
Image label_picture(const Gaussians& gaussians, const std::vector<int32_t>& row, const std::vector<bool>& residual,
                    const Camera& camera);

}  // namespace physmas::lift

#endif
