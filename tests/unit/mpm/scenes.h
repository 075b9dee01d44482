// Small scenes that the solver's tests share.
#ifndef PHYSMAS_TESTS_MPM_SCENES_H
#define PHYSMAS_TESTS_MPM_SCENES_H

#include <random>
#include <vector>

#include "mpm/simulation.h"

namespace mpm_test {

using namespace physmas;
using namespace physmas::mpm;

// Adds a block of particles, eight per cell of `dx`, with jitter so that nothing is aligned with the grid.
inline void add_block(Problem& p, const Vec3d& low, const Vec3d& high, int row, double dx, double jitter = 0.2,
                      const Vec3d& velocity = {0, 0, 0}) {
  const double h = dx / 2;
  std::mt19937 random(41 + row);
  std::uniform_real_distribution<double> shift(-jitter * h, jitter * h);
  for (double x = low.x + h / 2; x < high.x; x += h) {
    for (double y = low.y + h / 2; y < high.y; y += h) {
      for (double z = low.z + h / 2; z < high.z; z += h) {
        p.particles.position.push_back({x + shift(random), y + shift(random), z + shift(random)});
        p.particles.volume.push_back(h * h * h);
        p.particles.row.push_back(row);
        p.particles.velocity.push_back(velocity);
      }
    }
  }
}

// A domain of edge 2 with one material and no particles.
inline Problem scene(const Material& material, int n = 32, const Vec3d& gravity = {0, 0, 0}) {
  Problem p;
  p.domain.n = n;
  p.domain.gravity = gravity;
  p.materials.push_back(material);
  return p;
}

inline Options options(Precision precision = Precision::full, int threads = 2) {
  Options o;
  o.precision = precision;
  o.device.threads = threads;
  return o;
}

// Runs and keeps the last state.
struct Outcome {
  Result result;
  State state;
};
inline Outcome simulate(const Problem& p, const Timing& t, const Options& o = options()) {
  Outcome out;
  out.result = run(p, t, o, [&](const Frame& frame) { out.state = frame.state; });
  return out;
}

inline Vec3d mean(const std::vector<Vec3d>& values) {
  Vec3d sum{0, 0, 0};
  for (const Vec3d& v : values) sum = sum + v;
  return (1.0 / static_cast<double>(values.size())) * sum;
}

// What a stepper is made from, total_F included.
inline StepperSetup setup_of(const Problem& p, const ActionPlan& actions) {
  StepperSetup setup;
  setup.domain = p.domain;
  setup.contact = p.contact;
  for (const Material& m : p.materials) {
    setup.branches.push_back(m.branch);
    setup.parameters.push_back(derive_parameters(m, p.constants));
  }
  for (const Material& m : p.particles.material) setup.elasticity.push_back(elasticity_of(m));
  setup.row = p.particles.row;
  setup.volume = p.particles.volume;
  setup.control_group = actions.group_of();
  setup.track_total_F = true;
  return setup;
}

// A collider plane z = height.
inline Collider floor_at(double height, Collider::Mode mode = Collider::Mode::separate, double friction = 0) {
  Collider c;
  c.type = Collider::Type::plane;
  c.mode = mode;
  c.friction = friction;
  c.center = {0, 0, height};
  c.normal = {0, 0, 1};
  return c;
}

}  // namespace mpm_test

#endif
