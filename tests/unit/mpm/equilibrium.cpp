// What rests in its first frame rests in the simulation.
#include "mpm/equilibrium.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>

#include "mpm/material/constitutive.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

constexpr double kGravity = 9.8, kTop = 1.3125;

Problem column(const Material& material, Collider::Mode mode = Collider::Mode::sticky, double friction = 0) {
  Problem p = scene(material, 32, {0, 0, -kGravity});
  p.domain.colliders.push_back(floor_at(0.5, mode, friction));
  add_block(p, {0.8, 0.8, 0.5}, {1.2, 1.2, kTop}, 0, p.domain.dx());
  return p;
}

Device threads(int count) {
  Device device;
  device.threads = count;
  return device;
}

Problem balanced(Problem p, Equilibrium& found) {
  found = find_equilibrium(p, threads(2));
  p.particles.deformation_gradient = found.deformation_gradient;
  return p;
}

// Farthest that any particle comes from where it was at the start, at the output frames [m].
double farthest(const Problem& p, const Timing& t) {
  double most = 0;
  const Result result = run(p, t, options(Precision::single), [&](const Frame& frame) {
    for (size_t i = 0; i < frame.state.size(); ++i)
      most = std::max(most, norm(frame.state.x[i] - p.particles.position[i]));
  });
  REQUIRE(result.status == Status::stable);
  return most;
}

}  // namespace

TEST_CASE("mpm equilibrium: a column's stress is its weight over its section") {
  for (const Branch branch : {Branch::jelly, Branch::metal, Branch::foam}) {
    CAPTURE(std::string(branch_name(branch)));
    Problem p = column({branch, 2e6, 0.0, 1000});
    p.constants.foam_yield = 1e6;
    const Equilibrium found = find_equilibrium(p, threads(1));
    CHECK(found.supported_parts == 1);
    CHECK(found.supported_particles == static_cast<long long>(p.particles.size()));
    CHECK(found.residual < 0.02);
    CHECK(found.limited[0] == 0);
    // Means of layers of two cells. The one at the floor has its own stencil there, and the last one is free.
    const MaterialParameters<double> m = derive_parameters(p.materials[0], p.constants);
    for (double low = 0.625; low < 1.1; low += 0.125) {
      double stress = 0, weight = 0, volume = 0;
      for (size_t i = 0; i < p.particles.size(); ++i) {
        const double z = p.particles.position[i].z;
        if (z < low || z >= low + 0.125) continue;
        stress += branch_stress(branch, m, found.deformation_gradient[i])[2].z;
        weight += 1000 * kGravity * (kTop - z);
        volume += 1;
      }
      CAPTURE(low);
      CHECK(stress / volume == doctest::Approx(-weight / volume).epsilon(0.01));
    }
  }
}

TEST_CASE("mpm equilibrium: what stands stays, what would sag from rest") {
  for (const Branch branch : {Branch::jelly, Branch::metal}) {
    CAPTURE(std::string(branch_name(branch)));
    const Problem rest = column({branch, 1e5, 0.3, 1000});
    Equilibrium found;
    const Problem p = balanced(rest, found);
    const Timing t = {11, 0.04, 80};
    const double sags = farthest(rest, t), stays = farthest(p, t);
    CHECK(sags > 0.04);
    CHECK(stays < 0.03 * sags);
  }
}

TEST_CASE("mpm equilibrium: a beam that is fixed at one end") {
  Problem rest = scene({Branch::jelly, 4e6, 0.3, 1000}, 32, {0, 0, -kGravity});
  add_block(rest, {0.4, 0.9, 0.9}, {1.2, 1.1, 1.1}, 0, rest.domain.dx());
  Collider wall;
  wall.type = Collider::Type::box;
  wall.mode = Collider::Mode::sticky;
  wall.center = {0.3, 1, 1};
  wall.half_size = {0.2, 0.5, 0.5};
  rest.domain.colliders.push_back(wall);
  Equilibrium found;
  const Problem p = balanced(rest, found);
  CHECK(found.supported_parts == 1);
  CHECK(found.residual < 0.05);
  const Timing t = {11, 0.04, 100};
  const double sags = farthest(rest, t), stays = farthest(p, t);
  CHECK(sags > 0.04);
  CHECK(stays < 0.01 * sags);
}

TEST_CASE("mpm equilibrium: a slab that is held at the start supports") {
  Problem p = scene({Branch::jelly, 4e6, 0.3, 1000}, 32, {0, 0, -kGravity});
  add_block(p, {0.4, 0.9, 0.9}, {1.2, 1.1, 1.1}, 0, p.domain.dx());
  p.schedule.actions.push_back(SlabMotion{{0}, {0, 0, 0}, {-1, 0, 0}, 0.2, 0, 1});
  const Equilibrium found = find_equilibrium(p, threads(2));
  CHECK(found.supported_parts == 1);
  CHECK(found.residual < 0.05);
  // One that moves, or is held later only, does not.
  for (const SlabMotion& other :
       {SlabMotion{{0}, {0.1, 0, 0}, {-1, 0, 0}, 0.2, 0, 1}, SlabMotion{{0}, {0, 0, 0}, {-1, 0, 0}, 0.2, 0.1, 1}}) {
    p.schedule.actions[0] = other;
    CHECK(find_equilibrium(p, threads(2)).supported_parts == 0);
  }
}

TEST_CASE("mpm equilibrium: a floor that separates and rubs holds as well, and does not pull") {
  const Problem rest = column({Branch::jelly, 1e5, 0.3, 1000}, Collider::Mode::separate, 0.5);
  Equilibrium found;
  const Problem p = balanced(rest, found);
  CHECK(found.supported_parts == 1);
  CHECK(found.residual < 0.05);
  const Timing t = {11, 0.04, 80};
  CHECK(farthest(p, t) < 0.1 * farthest(rest, t));

  // Under a ceiling that only pushes it is in the air.
  Problem hanging = column({Branch::jelly, 1e5, 0.3, 1000});
  hanging.domain.colliders[0].center = {0, 0, 1.3};
  hanging.domain.colliders[0].normal = {0, 0, -1};
  CHECK(find_equilibrium(hanging, threads(1)).supported_parts == 1);
  hanging.domain.colliders[0].mode = Collider::Mode::separate;
  const Equilibrium dropped = find_equilibrium(hanging, threads(1));
  CHECK(dropped.supported_parts == 0);
  CHECK(dropped.free_parts == 1);
  CHECK(dropped.deformation_gradient.empty());
}

TEST_CASE("mpm equilibrium: what falls is left as it is, bit for bit") {
  Problem p = scene({Branch::jelly, 1e5, 0.3, 1000}, 32, {0, 0, -kGravity});
  p.domain.colliders.push_back(floor_at(0.3));
  add_block(p, {0.8, 0.8, 0.6}, {1.1, 1.1, 0.9}, 0, p.domain.dx());
  Equilibrium found = find_equilibrium(p, threads(2));
  CHECK(found.supported_parts == 0);
  CHECK(found.free_parts == 1);
  CHECK(found.deformation_gradient.empty());

  // Beside a block that stands, which is another part.
  Problem both = p;
  add_block(both, {0.8, 0.8, 0.3}, {1.1, 1.1, 0.45}, 0, p.domain.dx());
  const size_t falling = p.particles.size();
  found = find_equilibrium(both, threads(2));
  CHECK(found.supported_parts == 1);
  CHECK(found.free_parts == 1);
  CHECK(found.supported_particles == static_cast<long long>(both.particles.size() - falling));
  const Timing before_contact = {2, 0.04, 80};
  const Outcome from_rest = simulate(both, before_contact);
  both.particles.deformation_gradient = found.deformation_gradient;
  const Outcome out = simulate(both, before_contact);
  CHECK(std::memcmp(out.state.x.data(), from_rest.state.x.data(), falling * sizeof(Vec3d)) == 0);
  CHECK(std::memcmp(out.state.F.data(), from_rest.state.F.data(), falling * sizeof(Mat3d)) == 0);
  CHECK(out.state.x[falling].z != from_rest.state.x[falling].z);
}

TEST_CASE("mpm equilibrium: threads change no byte") {
  Problem p = column({Branch::foam, 2e5, 0.3, 1000}, Collider::Mode::separate, 0.3);
  p.constants.foam_yield = 3e3;  // so that it yields
  const Equilibrium one = find_equilibrium(p, threads(1));
  CHECK(one.limited[0] > 0);
  for (const int count : {2, 3}) {
    const Equilibrium found = find_equilibrium(p, threads(count));
    CHECK(found.iterations == one.iterations);
    CHECK(found.residual == one.residual);
    REQUIRE(found.deformation_gradient.size() == one.deformation_gradient.size());
    CHECK(std::memcmp(found.deformation_gradient.data(), one.deformation_gradient.data(),
                      one.deformation_gradient.size() * sizeof(Mat3d)) == 0);
  }
}

TEST_CASE("mpm equilibrium: nothing to carry") {
  Problem p = column({Branch::jelly, 1e5, 0.3, 1000});
  p.domain.gravity = {0, 0, 0};
  CHECK(find_equilibrium(p, threads(1)).deformation_gradient.empty());
  p = scene({}, 32, {0, 0, -kGravity});
  CHECK(find_equilibrium(p, threads(1)).deformation_gradient.empty());
}
