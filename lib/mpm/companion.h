// A coarse companion of a problem: the same scene on fewer cells, with as many particles per cell.
#ifndef PHYSMAS_MPM_COMPANION_H
#define PHYSMAS_MPM_COMPANION_H

#include <vector>

#include "mpm/simulation.h"

namespace physmas::mpm {

// Places of the same points at the output frames: [T][N] in m, solver space.
using PointPaths = std::vector<std::vector<Vec3d>>;

struct Companion {
  Problem problem;         // n / factor cells per axis
  std::vector<int> group;  // [N] per particle of the problem that it accompanies: the companion's particle that has it
};

// factor: 2 or more. Particles of one row in a cube of `factor` times their mean spacing (the cube root of the mean
// volume) become one: with the sum of their volumes, at their centre, with their mean velocity and material. Mass and
// momentum of every row are kept. A deformation at the start is not: it belongs to the grid that it was found on.
Companion make_companion(const Problem& problem, int factor);

// Where the first `points` particles of the accompanied problem are, x = x_q + F_q (X - X_q), q the companion's
// particle that has them, F its total deformation gradient. Takes time.substep as it is; result: filled when not null.
// Fewer frames than asked for where the run diverged.
PointPaths run_companion(const Companion& companion, const Particles& rest, size_t points, const Timing& timing,
                         const Device& device, Result* result = nullptr);

}  // namespace physmas::mpm

#endif
