// A motion of Gaussians as a USD layer.
#ifndef PHYSMAS_SPLAT_USD_SPLATS_H
#define PHYSMAS_SPLAT_USD_SPLATS_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scene/gaussians.h"
#include "splat/usd_crate.h"

namespace physmas::splat {

// One prim ParticleField3DGaussianSplat (OpenUSD 26.03), /Scene/Splats, with samples of what changes: positions and
// scales (linear) as float32, orientations and harmonics as halves, the extent of three standard deviations. Opacities
// (linear), and whatever stays the same, have one value.
class UsdSplats {
 public:
  // up: "y" or "z", along which the frames point. fps: frames per second; sample k is time code k.
  UsdSplats(const std::string& path, const std::string& up, double fps);
  // The next frame, of as many Gaussians as the first one, whose opacities and degree count. frame: its time code.
  void add(int frame, const Gaussians& gaussians);
  // At least one frame. Returns whether the file changed.
  bool commit();

 private:
  // Values of one attribute; the same bytes are written once.
  struct Track {
    std::string last;
    std::vector<UsdValue> values;
    std::vector<double> times;
  };
  void sample(Track& track, int frame, UsdType type, std::string bytes, size_t count);
  void attribute(const std::string& prim, const char* name, const char* type, const Track& track);

  UsdCrate crate_;
  std::string up_;
  double fps_;
  int first_ = 0, last_ = -1, degree_ = 0;
  Track positions_, orientations_, scales_, opacities_, harmonics_, extent_;
};

// The half that is nearest, ties to even; too large values become the largest finite one.
uint16_t half_of(float value);

}  // namespace physmas::splat

#endif
