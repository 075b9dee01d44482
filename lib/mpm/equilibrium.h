// What rests in its first frame rests in the simulation: the deformation that carries the weight of particles where
// they are. With F = I, the paper's start, everything begins without stress and first sags under its own weight.
#ifndef PHYSMAS_MPM_EQUILIBRIUM_H
#define PHYSMAS_MPM_EQUILIBRIUM_H

#include <vector>

#include "base/device.h"
#include "mpm/simulation.h"

namespace physmas::mpm {

// Parts are what particles connect by sharing nodes of the grid.
struct Equilibrium {
  // [N], symmetric; the identity for particles of parts that nothing holds up. Empty when there is nothing to carry.
  std::vector<Mat3d> deformation_gradient;
  int supported_parts = 0, free_parts = 0;
  long long supported_particles = 0;
  int iterations = 0;   // of conjugate gradients, in all
  int corrections = 0;  // of contacts that do not pull and of rows that yield
  // What is left of gravity, 0 to 1: the root mean square, by mass, of the accelerations that the supported particles
  // feel in the first substep, each up to gravity's, over that of gravity. 1 for F = I, but for particles that touch.
  double residual = 0;
  double largest_strain = 0;       // of the logarithms of principal stretches
  std::vector<long long> limited;  // particles per row that bear less than asked (carry_stress)
  double seconds = 0;              // run time; never part of a result's identity
};

// Solves the static balance of the problem at its start: the stress that balances gravity on every node that no
// collider, wall or held slab (an action that enforces velocity 0 from time 0 on) fixes, then F from the stress by each
// row's own law. The stress is that of a linear elastic body with the rows' E and ν in the particles' shape, so it is
// exact for soft rows too; where a row bears less, what is missing goes to its neighbours, as far as they bear it. A
// part on which the supports do not balance gravity, in the air or about to slide off, is left as it is. Initial
// velocities are not looked at. Throws invalid_input as check_problem. The result does not depend on device.threads.
Equilibrium find_equilibrium(const Problem& problem, const Device& device);

}  // namespace physmas::mpm

#endif
