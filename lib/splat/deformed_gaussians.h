// A deformed scene as a static one, for viewers that know nothing of deformation gradients.
#ifndef PHYSMAS_SPLAT_DEFORMED_GAUSSIANS_H
#define PHYSMAS_SPLAT_DEFORMED_GAUSSIANS_H

#include <cstdint>
#include <vector>

#include "splat/renderer.h"

namespace physmas::splat {

// The Gaussians as `deformation` leaves them (paper, Eq. gaussiantransport): transported means, scales and rotations of
// F Sigma0 F^T, harmonics turned by the proper polar rotation of F, opacities as they are. A Gaussian whose F is the
// identity keeps its stored values bit for bit; the others have unit quaternions, on the side of the rest one, and
// axes that stay in the order of the rest axes as far as the deformation lets them. Scales below 1e-30 scene units are
// written as that. A Gaussian whose position or F is not finite is left out, as the renderer does.
Gaussians deformed_gaussians(const Gaussians& rest, const Deformation& deformation);

// The frames of a motion, one after the other, for players that interpolate between them: as deformed_gaussians, but
// every Gaussian keeps its place in the arrays, and its axes are numbered and its quaternion has the sign that are
// nearest to those of the frame before.
class DeformedSequence {
 public:
  // rest: must outlive the sequence and not change.
  explicit DeformedSequence(const Gaussians& rest);
  // The next frame. A Gaussian whose position or F is not finite stays as it was in the frame before, and is not
  // `drawn` any more.
  void advance(const Deformation& deformation);
  const Gaussians& gaussians() const { return frame_; }
  // Those of the frame that are finite, in their order.
  Gaussians drawn() const;
  size_t hidden() const { return hidden_; }

 private:
  const Gaussians& rest_;
  Gaussians frame_;
  std::vector<uint8_t> drawn_;  // [N]
  size_t hidden_ = 0;
};

}  // namespace physmas::splat

#endif
