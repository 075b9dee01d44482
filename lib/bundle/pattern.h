// The colour of a primitive's surface from place to place: patterns and baked light.
#ifndef PHYSMAS_BUNDLE_PATTERN_H
#define PHYSMAS_BUNDLE_PATTERN_H

#include <Eigen/Core>

#include "base/random.h"
#include "bundle/surface.h"
#include "records/example.h"

namespace physmas::bundle {

// sRGB of the shape at a sample before light. low, high: the box of all of the shape's samples in its own frame.
// noise_seed: of the noise pattern; samples of one shape share it.
Eigen::Vector3d pattern_color(const ExampleShape& shape, const SurfaceSample& sample, const Eigen::Vector3d& low,
                              const Eigen::Vector3d& high, uint64_t noise_seed, Random& random);

// Light that is baked into the colours, so that shapes read in 3D: a sky, a key light from the front left above and
// a weaker one from behind. normal: unit, z up. gloss: strength of the highlight.
Eigen::Vector3d lit_color(const Eigen::Vector3d& color, const Eigen::Vector3d& normal, double gloss);

}  // namespace physmas::bundle

#endif
