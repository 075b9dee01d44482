#include "studies/verification.h"

#include <fmt/format.h>

#include <cmath>

#include "studies/verification_cases.h"

namespace physmas::studies {
namespace {

class Table {
 public:
  explicit Table(bool quick) : quick_(quick) {}

  // measured(r) over the resolutions, coarse to fine; `ratio` is the refinement factor between two of them where the
  // order of the error means something.
  template <class Measure>
  void refine(const std::string& name, const std::string& source, double expected, const std::string& parameter,
              const std::vector<double>& values, bool with_order, const Measure& measured) {
    for (size_t k = 0; k < (quick_ ? 1 : values.size()); ++k) {
      VerificationRow row{name,  fmt::format("{} = {:g}", parameter, values[k]), expected, measured(values[k]), 0,
                          source};
      if (with_order && k > 0) {
        const double finer = std::fabs(std::log(values[k] / values[k - 1]));
        row.order = std::log(std::fabs(rows.back().error() / row.error())) / finer;
      }
      rows.push_back(row);
    }
  }

  std::vector<VerificationRow> rows;

 private:
  bool quick_;
};

}  // namespace

std::vector<VerificationRow> verify(bool quick, const Device& device) {
  Table t(quick);
  t.refine("free fall: distance from z0 - g t^2/2 [m]", "analytic; g t dt/2 for symplectic Euler", 0, "dt",
           {4e-4, 2e-4, 1e-4}, true, [&](double dt) { return free_fall_error(dt, device); });
  t.refine("rotation: change of angular momentum", "conservation", 0, "n", {20, 40}, false,
           [&](double n) { return rigid_rotation(static_cast<int>(n), 4e-4, device).momentum_drift; });
  t.refine("rotation: angle after a turn [rad]", "analytic, with the inertia of the affine fields", 0, "n", {20, 40},
           false, [&](double n) { return rigid_rotation(static_cast<int>(n), 4e-4, device).angle_error; });
  t.refine("bar: frequency / analytic", "c / 2L", 1, "n", {32, 64, 128}, true,
           [&](double n) { return bar_frequency(static_cast<int>(n), 2e-4, device); });
  // The limit of vanishing dt has the spatial error; what is left above it is that of the time integration.
  const double limit = bar_frequency(64, 2.5e-4, device);
  t.refine("bar: frequency / analytic, n = 64", "the same at dt = 2.5e-4", limit, "dt", {2e-3, 1e-3}, true,
           [&](double dt) { return bar_frequency(64, dt, device); });
  t.refine("column: error / settlement", "rho g/E (H Z - Z^2/2)", 0, "n", {20, 40, 80}, true,
           [&](double n) { return column_error(static_cast<int>(n), 2e-3 / n, device); });
  t.refine("balls: change of momentum", "conservation", 0, "n", {32, 64}, false,
           [&](double n) { return ball_collision(static_cast<int>(n), 0.05 / n, device).momentum_error; });
  t.refine("balls: restitution, dt ~ dx", "1 for slow elastic impact", 1, "n", {24, 32, 48, 64}, false,
           [&](double n) { return ball_collision(static_cast<int>(n), 0.1 / n, device).restitution; });
  t.refine("balls: restitution, n = 48", "1 for slow elastic impact", 1, "dt", {2e-3, 1e-3, 5e-4, 2.5e-4}, false,
           [&](double dt) { return ball_collision(48, dt, device).restitution; });
  t.refine("incline 30 deg, friction 0.3: acceleration / g", "sin a - mu cos a", 0.5 - 0.3 * std::sqrt(0.75), "n",
           {20, 40, 80}, false,
           [&](double n) { return incline_acceleration(static_cast<int>(n), 2.5e-4, 0.3, 30, device); });
  t.refine("incline 20 deg, friction 0.5: acceleration / g", "0: it sticks", 0, "n", {20, 40, 80}, false,
           [&](double n) { return incline_acceleration(static_cast<int>(n), 2.5e-4, 0.5, 20, device); });
  for (const double aspect : {0.5, 1.0, 2.5}) {
    for (const double alpha : {0.16, 0.327}) {
      t.refine(fmt::format("sand column: run-out, a = {:g}, alpha = {:g}", aspect, alpha), "Lube et al. 2004",
               lube_run_out(aspect), "n", {32, 48, 64}, false,
               [&](double n) { return sand_run_out(static_cast<int>(n), 0.024 / n, aspect, alpha, device); });
    }
  }
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    t.refine(fmt::format("energy residual / initial energy, {}", mpm::kBranchNames[b]), "closed budget", 0, "dt",
             {4e-4, 1e-4, 2.5e-5, 1.25e-5}, true,
             [&](double dt) { return energy_residual_of_throw(static_cast<mpm::Branch>(b), dt, device); });
  }
  return t.rows;
}

std::string verification_table(const std::vector<VerificationRow>& rows) {
  std::string text = fmt::format("{:<52} {:<12} {:>11} {:>11} {:>10} {:>6}  {}\n", "quantity", "resolution", "expected",
                                 "measured", "error", "order", "expected from");
  for (const VerificationRow& r : rows) {
    text += fmt::format("{:<52} {:<12} {:>11.5g} {:>11.5g} {:>10.2e} {:>6}  {}\n", r.name, r.resolution, r.expected,
                        r.measured, r.error(), r.order != 0 ? fmt::format("{:.2f}", r.order) : "", r.source);
  }
  return text;
}

}  // namespace physmas::studies
