// The run's box as the solver's domain: every collider, mode and number arrives where it belongs.
#include "bind/domain.h"

#include <doctest/doctest.h>

using namespace physmas;

namespace {

using Record = RunSpecification::Collider;

void check_vector(const mpm::Vec3d& found, const Eigen::Vector3d& expected) {
  for (int k = 0; k < 3; ++k) CHECK(found[k] == expected[k]);
}

}  // namespace

TEST_CASE("bind: grid, gravity and walls are the run's") {
  RunSpecification run;
  run.grid.n = 48;
  run.grid.length = 3;
  run.gravity = {1, -2, 4};
  run.walls = 5;
  const mpm::Domain domain = bind::bind_domain(run);
  CHECK(domain.n == 48);
  CHECK(domain.length == 3);
  check_vector(domain.gravity, {1, -2, 4});
  CHECK(domain.wall_cells == 5);
  CHECK(domain.colliders.empty());
}

TEST_CASE("bind: every type of collider in every mode, in the run's order") {
  const std::pair<Record::Mode, mpm::Collider::Mode> modes[] = {
      {Record::Mode::sticky, mpm::Collider::Mode::sticky},
      {Record::Mode::slip, mpm::Collider::Mode::slip},
      {Record::Mode::separate, mpm::Collider::Mode::separate}};
  RunSpecification run;
  double friction = 0;
  for (const auto& [mode, expected] : modes) {
    Record plane, box, sphere;
    plane.type = Record::Type::plane;
    plane.point = {0.1, 0.2, 0.3};
    plane.normal = {0, 0.6, 0.8};
    box.type = Record::Type::box;
    box.min = {0.2, 0.4, 0.6};
    box.max = {0.6, 1.0, 1.4};
    sphere.type = Record::Type::sphere;
    sphere.point = {1.1, 1.2, 1.3};
    sphere.radius = 0.25;
    for (Record* record : {&plane, &box, &sphere}) {
      record->mode = mode;
      record->friction = friction += 0.05;
      run.colliders.push_back(*record);
    }
  }
  const mpm::Domain domain = bind::bind_domain(run);
  REQUIRE(domain.colliders.size() == 9);
  for (size_t i = 0; i < 9; ++i) {
    CHECK(domain.colliders[i].mode == modes[i / 3].second);
    CHECK(domain.colliders[i].friction == run.colliders[i].friction);
  }
  for (size_t i = 0; i < 9; i += 3) {
    const mpm::Collider &plane = domain.colliders[i], &box = domain.colliders[i + 1], &sphere = domain.colliders[i + 2];
    CHECK(plane.type == mpm::Collider::Type::plane);
    check_vector(plane.center, {0.1, 0.2, 0.3});
    check_vector(plane.normal, {0, 0.6, 0.8});
    CHECK(box.type == mpm::Collider::Type::box);
    for (int k = 0; k < 3; ++k) {
      // Its faces are where the run has them.
      CHECK(box.center[k] - box.half_size[k] == doctest::Approx(run.colliders[1].min[k]).epsilon(1e-15));
      CHECK(box.center[k] + box.half_size[k] == doctest::Approx(run.colliders[1].max[k]).epsilon(1e-15));
    }
    CHECK(sphere.type == mpm::Collider::Type::sphere);
    check_vector(sphere.center, {1.1, 1.2, 1.3});
    CHECK(sphere.radius == 0.25);
  }
}
