// The scenes that the solver's speed is measured on: a cube of jittered particles, eight per cell, turned against the
// grid, that falls and is squeezed by its initial velocity field, so that return maps are at work.
#ifndef PHYSMAS_TESTS_BENCH_CUBE_H
#define PHYSMAS_TESTS_BENCH_CUBE_H

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "mpm/simulation.h"

namespace bench {

using namespace physmas;
using namespace physmas::mpm;

struct BenchCase {
  std::string name;
  std::vector<Branch> branches;  // a row each, in slabs
  bool yields = true;            // else strengths are out of reach
  bool turned = true;            // else aligned with the grid
  bool field = false;            // every particle has a material of its own
};

inline Problem make_problem(int count, const BenchCase& bench) {
  Problem p;
  p.domain.n = 100;
  p.domain.gravity = {0, 0, -9.8};
  const double spacing = p.domain.dx() / 2;
  const int side = static_cast<int>(std::lround(std::cbrt(static_cast<double>(count))));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-0.25, 0.25);
  // Half a radian about (1, 1, 1).
  const double angle = bench.turned ? 0.5 : 0.0;
  const double c = std::cos(angle), s = std::sin(angle) / std::sqrt(3.0), d = (1 - c) / 3;
  const Mat3d R = {{{c + d, d - s, d + s}, {d + s, c + d, d - s}, {d - s, d + s, c + d}}};
  for (const Branch b : bench.branches) {
    const double E = b == Branch::sand || b == Branch::snow ? 1e5 : 2e5;
    p.materials.push_back({b, E, 0.3, b == Branch::foam ? 200.0 : 1000.0});
  }
  if (!bench.yields) p.constants.foam_yield = 1e12;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      for (int k = 0; k < side; ++k) {
        const double h = 0.5 * (side - 1);
        const Vec3d q = {spacing * (i - h + jitter(random)), spacing * (j - h + jitter(random)),
                         spacing * (k - h + jitter(random))};
        p.particles.position.push_back(Vec3d{1, 1, 1} + R * q);
        p.particles.volume.push_back(spacing * spacing * spacing);
        p.particles.row.push_back(static_cast<int>((i * bench.branches.size()) / side));
        // A squeeze strong enough to make every plastic branch yield.
        if (bench.field) {
          Material own = p.materials[p.particles.row.back()];
          own.E *= 1 + 0.5 * jitter(random);
          p.particles.material.push_back(own);
        }
        p.particles.velocity.push_back({-1.0 * q.x, 1.5 * q.y, -3.0 * q.z});
      }
    }
  }
  return p;
}

}  // namespace bench

#endif
