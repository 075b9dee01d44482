// Pictures for looking: which row every Gaussian got.
#ifndef PHYSMAS_LIFT_LABEL_PICTURE_H
#define PHYSMAS_LIFT_LABEL_PICTURE_H

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "scene/image.h"

namespace physmas::lift {

// The scene over white, every Gaussian in its row's colour (splat/row_colors.h). row: [N]; residual: [rows].
Image label_picture(const Gaussians& gaussians, const std::vector<int32_t>& row, const std::vector<bool>& residual,
                    const Camera& camera);

}  // namespace physmas::lift

#endif
