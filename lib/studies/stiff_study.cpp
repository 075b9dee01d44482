#include "studies/stiff_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mpm/material/constitutive.h"
#include "mpm/timestep.h"

namespace physmas::studies {
namespace {

using mpm::Vec3d;
using Paths = std::vector<std::vector<Vec3d>>;

mpm::Timing timing_of(const StiffCase& scene, const StiffStudyPlan& plan, double dt) {
  mpm::Timing timing;
  timing.frames = 1 + static_cast<int>(std::lround(scene.duration / plan.frame_dt));
  timing.frame_dt = plan.frame_dt;
  timing.substeps = static_cast<int>(std::ceil(plan.frame_dt / dt * (1 - 1e-9)));
  return timing;
}

double stepping_seconds(const mpm::Result& result) {
  return result.seconds_particles + result.seconds_grid + result.seconds_sort;
}

Paths paths_of(const mpm::Problem& problem, const mpm::Timing& timing, const mpm::Options& options,
               mpm::Result& result) {
  Paths paths;
  result = mpm::run(problem, timing, options, [&](const mpm::Frame& frame) { paths.push_back(frame.state.x); });
  return paths;
}

// The longest edge [m] of the box around a row at rest, with half a spacing on each side.
double size_of(const mpm::Particles& p, int row) {
  Vec3d low = {1e30, 1e30, 1e30}, high = {-1e30, -1e30, -1e30};
  double volume = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    if (p.row[i] != row) continue;
    volume = p.volume[i];
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], p.position[i][a]);
      high[a] = std::max(high[a], p.position[i][a]);
    }
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z}) + std::cbrt(volume);
}

double largest_error(const Paths& reference, const Paths& paths, const mpm::Particles& p, int row) {
  double largest = 0;
  for (size_t t = 0; t < std::min(reference.size(), paths.size()); ++t) {
    double sum = 0;
    long count = 0;
    for (size_t i = 0; i < p.size(); ++i) {
      if (p.row[i] != row) continue;
      const Vec3d d = paths[t][i] - reference[t][i];
      sum += dot(d, d);
      ++count;
    }
    if (count > 0) largest = std::max(largest, std::sqrt(sum / static_cast<double>(count)));
  }
  return largest / size_of(p, row);
}

double energy_rise(const mpm::Result& result) {
  double lowest = result.balances.front().energy(), rise = 0, kinetic = 1e-300;
  for (const mpm::Balance& b : result.balances) {
    const double total = b.energy();
    rise = std::max(rise, total - lowest);
    lowest = std::min(lowest, total);
    kinetic = std::max(kinetic, b.kinetic);
  }
  return rise / kinetic;
}

}  // namespace

std::vector<StiffStudy> run_stiff_study(const StiffStudyPlan& plan, const Device& device,
                                        const std::function<void()>& done) {
  std::vector<StiffStudy> studies;
  for (const StiffCase& scene : stiff_cases(plan.youngs_modulus)) {
    if (!plan.only.empty() && scene.name != plan.only) continue;
    StiffStudy study;
    study.name = scene.name, study.text = scene.text, study.held_out = scene.held_out;
    study.goal_stiff = scene.goal_stiff, study.goal_other = scene.goal_other;
    const mpm::Problem soft = all_soft(scene).problem;
    double limit = plan.dt;
    for (const int row : scene.stiff) {
      const auto p = mpm::derive_parameters(scene.problem.materials[row], scene.problem.constants);
      limit = std::min(limit, 0.7 * mpm::rest_limit(p, scene.problem.domain.dx()));
    }
    mpm::Options options;
    options.device = device;
    const mpm::Timing timing = timing_of(scene, plan, plan.dt), fine = timing_of(scene, plan, limit);
    mpm::Result result;
    paths_of(soft, timing, options, result);
    const double soft_seconds = stepping_seconds(result);
    options.stiff = mpm::StiffRule::rigid;
    options.impact_budget = plan.impact_budget;
    const Paths rigid = paths_of(scene.problem, timing, options, result);
    StiffOutcome& out = study.rigid;
    out.diverged = result.status == mpm::Status::diverged;
    out.cost = stepping_seconds(result) / soft_seconds;
    out.energy_rise = energy_rise(result);
    out.windows = result.impacts.windows, out.small_steps = result.impacts.small_steps;
    for (const mpm::RigidBodyReport& body : result.rigid_bodies) {
      out.impacts += body.impacts;
      out.restitution = std::max(out.restitution, body.restitution);
      out.error_bound = std::max(out.error_bound, body.error);
    }
    options.stiff = mpm::StiffRule::off;
    options.precision = mpm::Precision::full;
    const Paths resolved = paths_of(scene.problem, fine, options, result);
    study.resolved_dt = result.dt;
    study.resolved_cost = stepping_seconds(result) / soft_seconds;
    const mpm::Particles& p = scene.problem.particles;
    for (int row = 0; row < static_cast<int>(scene.problem.materials.size()); ++row) {
      const bool stiff = std::find(scene.stiff.begin(), scene.stiff.end(), row) != scene.stiff.end();
      double& worst = stiff ? out.stiff_error : out.other_error;
      worst = std::max(worst, largest_error(resolved, rigid, p, row));
    }
    studies.push_back(std::move(study));
    done();
  }
  return studies;
}

std::string stiff_table(const std::vector<StiffStudy>& studies) {
  std::string text =
      fmt::format("{:<18} {:>7} {:>7} {:>6} {:>8} {:>7} {:>6} {:>6} {:>6} {:>8} {:>8}\n", "case", "stiff %", "other %",
                  "cost", "resolved", "windows", "small", "own", "e", "bound %", "rise");
  for (const StiffStudy& s : studies) {
    const StiffOutcome& o = s.rigid;
    text += fmt::format("{:<18} {:>7.2f} {:>7.2f} {:>6.2f} {:>8.1f} {:>7} {:>6} {:>6} {:>6.2f} {:>8.4f} {:>8.1e}{}\n",
                        s.name, 100 * o.stiff_error, 100 * o.other_error, o.cost, s.resolved_cost, o.windows,
                        o.small_steps, o.impacts, o.restitution, 100 * o.error_bound, o.energy_rise,
                        o.diverged   ? "  DIVERGED"
                        : s.held_out ? "  held out"
                                     : "");
  }
  return text;
}

}  // namespace physmas::studies
