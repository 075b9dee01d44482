// The calibrated view images of a scene bundle.
#ifndef PHYSMAS_BUNDLE_VIEWS_H
#define PHYSMAS_BUNDLE_VIEWS_H

#include <string>
#include <vector>

#include "records/run_specification.h"
#include "scene/camera.h"
#include "scene/gaussians.h"
#include "scene/image.h"

namespace physmas::bundle {

constexpr int kViewSize = 640;       // pixels, width and height of the views that we render
constexpr double kViewFov = 40;      // degrees
constexpr double kViewMargin = 0.1;  // see Framing

// RGBA, one image per camera: RGB over the run's background, alpha as rendered.
std::vector<Image> render_view_images(const Gaussians& gaussians, const std::vector<Camera>& cameras,
                                      const RunSpecification::Render& render);

}  // namespace physmas::bundle

#endif
