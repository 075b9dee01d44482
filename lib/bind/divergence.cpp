#include "bind/divergence.h"

#include <fmt/format.h>

namespace physmas::bind {
namespace {

// "70 GPa"
std::string pascals(double E) {
  if (E >= 1e9) return fmt::format("{:.3g} GPa", E / 1e9);
  if (E >= 1e6) return fmt::format("{:.3g} MPa", E / 1e6);
  return E >= 1e3 ? fmt::format("{:.3g} kPa", E / 1e3) : fmt::format("{:.3g} Pa", E);
}

std::string advice_of(const Divergence& d, const BoundTiming& timing, const mpm::Options& options) {
  const std::string who = fmt::format("{} (E {})", d.row, pascals(d.E));
  if (d.cause == "budget") {
    return fmt::format(
        "{} is so stiff that it needs substeps of {:.2g} s, more than the {} substeps that are allowed; give it a "
        "softer "
        "material, or use larger cells, SET=\"grid.n=48\"",
        who, d.needed_dt, options.max_steps);
  }
  const std::string where = fmt::format("before frame {} of {}", d.frame, timing.timing.frames - 1);
  if (d.cause == "step") {
    return fmt::format(
        "the motion breaks down {}: {} is too stiff for substeps of {:.2g} s, it needs {:.2g} s; try "
        "SET=\"time.rule=cfl\", which takes as many as that asks for, or give it a softer material",
        where, who, d.dt, d.needed_dt);
  }
  return fmt::format(
      "the motion breaks down {}: {} is moved faster than its material can follow; ask for a gentler or slower "
      "action{}",
      where, who, timing.rule == "cfl" ? "" : ", or try SET=\"time.rule=cfl\"");
}

}  // namespace

Divergence explain_divergence(const Candidate& candidate, const mpm::Problem& problem, const BoundTiming& timing,
                              const mpm::Options& options, const mpm::Result& result) {
  Divergence d;
  d.dx = problem.domain.dx();
  d.dt = result.dt;
  d.frame = result.frames_done;
  d.wave_speed = d.dx / result.stiffest_limit;
  d.needed_dt =
      mpm::choose_step({result.stiffest_limit, 0, 0}, problem.domain, timing.timing.frame_dt / timing.timing.substeps);
  int row = result.stiffest_row;
  if (result.reason == "budget") {
    d.cause = "budget";
  } else if (result.reason == "step" || (timing.rule != "cfl" && d.dt > result.stiffest_limit)) {
    d.cause = "step";
  } else {
    d.cause = "motion";
    row = result.fault_row;
  }
  for (const CandidateRow& r : candidate.rows) {
    if (r.row == row) d.row = r.key, d.E = r.E;
  }
  d.advice = advice_of(d, timing, options);
  return d;
}

}  // namespace physmas::bind
