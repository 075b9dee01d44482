// A deformed scene as a static one, for viewers that know nothing of deformation gradients.
#ifndef PHYSMAS_SPLAT_DEFORMED_GAUSSIANS_H
#define PHYSMAS_SPLAT_DEFORMED_GAUSSIANS_H

#include "splat/renderer.h"

namespace physmas::splat {

// The Gaussians as `deformation` leaves them (paper, Eq. gaussiantransport): transported means, scales and rotations of
// F Sigma0 F^T, harmonics turned by the proper polar rotation of F, opacities as they are. A Gaussian whose F is the
// identity keeps its stored values bit for bit; the others have unit quaternions, on the side of the rest one, and
// axes that stay in the order of the rest axes as far as the deformation lets them. Scales below 1e-30 scene units are
// written as that. A Gaussian whose position or F is not finite is left out, as the renderer does.
Gaussians deformed_gaussians(const Gaussians& rest, const Deformation& deformation);

}  // namespace physmas::splat

#endif
