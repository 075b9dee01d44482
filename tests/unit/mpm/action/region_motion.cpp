// What is measured of a moved set of particles, on motions whose numbers are known.
#include "mpm/action/region_motion.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace physmas::mpm;
using doctest::Approx;

namespace {

// A lopsided heap: no symmetry hides a mistake.
const Places kHeap = {{1, 0, 0}, {1.2, 0.1, 0.3}, {0.7, -0.4, 0.1}, {1.1, 0.5, -0.2}, {0.9, 0.2, 0.7}};

// Turned about z through (3, -2, 0), then shifted.
Places turned(double angle, const Vec3d& shift) {
  Places out;
  for (const Vec3d& x : kHeap) {
    const Vec3d r = x - Vec3d{3, -2, 0};
    out.push_back(
        Vec3d{3, -2, 0} + shift +
        Vec3d{std::cos(angle) * r.x - std::sin(angle) * r.y, std::sin(angle) * r.x + std::cos(angle) * r.y, r.z});
  }
  return out;
}

}  // namespace

TEST_CASE("mpm region motion: an angle is that of a rigid turn, wherever its axis is and whatever else moves") {
  for (const double angle : {0.0, 0.3, -1.2, 3.0})
    CHECK(turn_about({0, 0, 1}, kHeap, turned(angle, {0.5, 1, -3})) == Approx(angle).epsilon(1e-12));
  CHECK(turn_about({0, 0, -1}, kHeap, turned(0.3, {0, 0, 0})) == Approx(-0.3));
  // About another axis, or where all lies on it, nothing has turned.
  CHECK(std::fabs(turn_about({1, 0, 0}, kHeap, kHeap)) < 1e-15);
  CHECK(turn_about({0, 0, 1}, {{1, 1, 0}, {1, 1, 2}}, {{1, 1, 0}, {1, 1, 5}}) == 0);
}

TEST_CASE("mpm region motion: distances, stretch and radius") {
  const Vec3d shift = {0.3, -0.4, 1.2};
  CHECK(mean_distance(kHeap, turned(0, shift)) == Approx(1.3));
  Places squashed = kHeap;
  for (Vec3d& x : squashed) x = {x.x + 0.2 * x.z, x.y, 0.6 * x.z + 5};
  CHECK(stretch_along({0, 0, 1}, kHeap, squashed) == Approx(0.6));
  CHECK(stretch_along({0, 1, 0}, kHeap, squashed) == Approx(1));
  CHECK(stretch_along({0, 0, 1}, {{0, 0, 1}, {1, 0, 1}}, {{0, 0, 1}, {1, 0, 3}}) == 1);
  CHECK(radius_about({0, 0, 1}, {{1, 0, 4}, {-1, 0, 2}, {0, 1, 0}, {0, -1, 7}}) == Approx(1));
  CHECK(radius_about({1, 0, 0}, {{1, 0, 2}, {-1, 0, -2}}) == Approx(2));
}
