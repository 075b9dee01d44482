// Contact of a node's velocity with a collider, in closed form.
#include "mpm/action/collider.h"

#include <doctest/doctest.h>

using namespace physmas::mpm;

TEST_CASE(
    "mpm contact: friction takes from the tangential speed what was pressed in, and nothing where material leaves") {
  using Mode = Collider::Mode;
  const auto kept = [](Mode mode, const Vec3d& velocity, double distance = -0.01) {
    Collider collider;
    collider.mode = mode;
    collider.friction = 0.5;
    return apply_contact(collider, {distance, {0, 0, 1}}, velocity);
  };
  const auto equal = [](const Vec3d& a, const Vec3d& b) { return norm(a - b) < 1e-15; };
  for (const Mode mode : {Mode::slip, Mode::separate}) {
    CHECK(equal(kept(mode, {3, 0, -2}), {2, 0, 0}));  // 3 - 0.5 * 2
    CHECK(equal(kept(mode, {0, -3, -2}), {0, -2, 0}));
    CHECK(equal(kept(mode, {0.6, 0.8, -2}), {0, 0, 0}));  // all of it: it sticks
  }
  CHECK(equal(kept(Mode::slip, {3, 0, 2}), {3, 0, 0}));
  CHECK(equal(kept(Mode::separate, {3, 0, 2}), {3, 0, 2}));
  CHECK(equal(kept(Mode::sticky, {3, 0, 2}), {0, 0, 0}));
  for (const Mode mode : {Mode::sticky, Mode::slip, Mode::separate})
    CHECK(equal(kept(mode, {3, 0, -2}, 0.01), {3, 0, -2}));  // outside
}
