// The solver against analytic answers, at resolutions that take a fraction of a second. `pm-eval verification` shows
// the same quantities under refinement.
#include <doctest/doctest.h>

#include <cmath>

#include "studies/verification_cases.h"

using namespace physmas;
using namespace physmas::studies;

TEST_CASE("verification: free fall is of first order in dt") {
  // Symplectic Euler: g t dt / 2.
  CHECK(free_fall_error(4e-4) == doctest::Approx(0.5 * 9.8 * 0.2 * 4e-4).epsilon(1e-6));
  CHECK(free_fall_error(2e-4) == doctest::Approx(0.5 * 9.8 * 0.2 * 2e-4).epsilon(1e-6));
}

TEST_CASE("verification: a turning cube keeps its angular momentum and turns as far as its inertia says") {
  const Rotation r = rigid_rotation(20, 5e-4);
  CHECK(r.momentum_drift < 1e-12);  // rounding of two thousand steps
  CHECK(r.angle_error < 0.005);     // measured 4e-4: the cube swells a little as it turns
}

TEST_CASE("verification: the lowest longitudinal mode of a bar, second order in dx") {
  const double coarse = std::fabs(bar_frequency(32, 5e-4) - 1), fine = std::fabs(bar_frequency(64, 5e-4) - 1);
  CHECK(coarse < 0.005);  // measured 0.0040 with 16 cells
  CHECK(std::log2(coarse / fine) == doctest::Approx(2).epsilon(0.1));
}

TEST_CASE("verification: the static settlement of a column, first order in dx") {
  const double coarse = column_error(20, 4e-4), fine = column_error(40, 2e-4);
  // The floor acts at nodes, so the contact surface is known to a fraction of a cell: measured 0.066 with 8 cells.
  CHECK(coarse < 0.08);
  CHECK(std::log2(coarse / fine) == doctest::Approx(1).epsilon(0.1));
}

TEST_CASE("verification: two balls keep their momentum and part more elastically on a finer grid") {
  const Collision coarse = ball_collision(24, 0.1 / 24), fine = ball_collision(40, 0.1 / 40);
  CHECK(coarse.momentum_error < 1e-13);
  CHECK(fine.momentum_error < 1e-13);
  CHECK(fine.restitution > coarse.restitution);
  CHECK(fine.restitution > 0.88);  // 1 without the losses of the transfers
  CHECK(fine.restitution < 1);
}

TEST_CASE("verification: Coulomb friction on an incline, sliding and sticking") {
  // Mean over 0.16 s; what is left is the elastic swing of the block.
  CHECK(incline_acceleration(20, 5e-4, 0.3, 30) == doctest::Approx(0.5 - 0.3 * std::sqrt(0.75)).epsilon(0.01));
  CHECK(std::fabs(incline_acceleration(20, 5e-4, 0.5, 20)) < 0.005);
}

TEST_CASE("verification: the run-out of a sand column follows Lube's scaling") {
  const double low = sand_run_out(32, 1e-3, 0.5, 0.16), high = sand_run_out(32, 1e-3, 1, 0.16);
  // Eight particles across the foot's height: the front is short by a cell or two; measured 0.40 and 1.07.
  CHECK(low > 0.5 * lube_run_out(0.5));
  CHECK(low < 1.2 * lube_run_out(0.5));
  CHECK(high == doctest::Approx(lube_run_out(1)).epsilon(0.25));
}
