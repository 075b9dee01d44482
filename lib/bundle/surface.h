// Surfaces of primitives, and their even covering with samples.
#ifndef PHYSMAS_BUNDLE_SURFACE_H
#define PHYSMAS_BUNDLE_SURFACE_H

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "base/random.h"
#include "records/example.h"

namespace physmas::bundle {

// A piece of a surface over (u, v) in [0, 1]^2, smooth inside; the normal is d/du x d/dv, outwards.
struct SurfacePatch {
  std::function<Eigen::Vector3d(double u, double v)> at;  // scene units, the shape's own frame
  bool closed = false;                                    // v = 0 and v = 1 are the same place
};

struct Surface {
  std::vector<SurfacePatch> patches;
  std::function<bool(const Eigen::Vector3d&)> contains;  // whether a point is in the solid; never for open surfaces
  bool two_sided = false;                                // seen from both sides: discs and leaves
};

// A sample with the extent of the cell that it stands for.
struct SurfaceSample {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;   // unit
  Eigen::Vector3d along_u;  // cell edge along u, |along_u| about the spacing
  Eigen::Vector3d along_v;  // cell edge along v
  double u = 0, v = 0;      // where in its patch
};

// The shape's surface around its own centre, before rotation.
Surface make_surface(const ExampleShape& shape);

// Rows of samples about `spacing` apart, each row turned by a random phase where the patch is closed. spacing > 0.
// Stops at limit + 1 samples.
std::vector<SurfaceSample> sample_patch(const SurfacePatch& patch, double spacing, Random& random, size_t limit);

}  // namespace physmas::bundle

#endif
