// Depth images as 16-bit pictures.
#ifndef PHYSMAS_SPLAT_DEPTH_PICTURE_H
#define PHYSMAS_SPLAT_DEPTH_PICTURE_H

#include <string>
#include <vector>

#include "records/state.h"
#include "scene/camera.h"
#include "splat/renderer.h"

namespace physmas::splat {

// Scene units per level of the depth pictures of a rollout: such that level 65535 is the depth of the solver cube's
// farthest corner as any of the cameras sees it. Nothing that the solver moves is farther away. 1 when the cube lies
// behind every camera.
double depth_unit(const std::vector<Camera>& cameras, const SolverMap& map);

// Writes the depth image as a grey PNG of 16 bits: level = depth / unit, rounded, 1..65535; 0: nothing drawn (alpha
// below 1/255). Atomic; the same pixels give the same bytes. Returns whether the file changed. Errors as save_png.
bool save_depth_png(const std::string& path, const RenderedImage& image, double unit);

}  // namespace physmas::splat

#endif
