#include "bind/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "records/json.h"

namespace physmas::bind {
namespace {

int candidate_substeps(const TimestepResult& step, double frame_dt, const std::string& file) {
  if (std::abs(step.substeps * step.dt - frame_dt) > 1e-9 * frame_dt) {
    throw invalid_field(file, "/timestep/dt", step.dt,
                        fmt::format("{} substeps that fill a frame of {} s", step.substeps, frame_dt),
                        "make the candidates again with pm-candidates");
  }
  return step.substeps;
}

double parse_seconds(const std::string& rule, double frame_dt) {
  size_t used = 0;
  double seconds = 0;
  try {
    seconds = std::stod(rule, &used);
  } catch (const std::exception&) {
  }
  if (used != rule.size() || !(seconds > 0) || !(frame_dt / seconds < 1e7)) {
    throw Error(ExitCode::usage,
                fmt::format("--timestep: found \"{}\", expected paper, cfl or a positive number of seconds", rule));
  }
  return seconds;
}

}  // namespace

mpm::StiffRule bind_stiff_rule(const std::string& rule) {
  if (rule == "rigid") return mpm::StiffRule::rigid;
  return rule == "auto" ? mpm::StiffRule::automatic : mpm::StiffRule::off;
}

int whole_substeps(double dt, double frame_dt) {
  return std::max(1, static_cast<int>(std::ceil(frame_dt / dt * (1 - 1e-9))));
}

BoundTiming bind_timing(const std::string& rule, const RunSpecification::Time& time, const Candidate& candidate,
                        const std::string& file) {
  BoundTiming bound;
  bound.timing.frames = time.frames;
  bound.timing.frame_dt = time.frame_dt;
  bound.rule = rule;
  if (rule == "paper") {
    bound.timing.substeps = candidate_substeps(candidate.timestep, time.frame_dt, file);
  } else if (rule == "cfl") {
    bound.timing.rule = mpm::StepRule::cfl;
    bound.timing.substeps = whole_substeps(time.substep_dt, time.frame_dt);
  } else {
    bound.timing.substeps = whole_substeps(parse_seconds(rule, time.frame_dt), time.frame_dt);
    bound.rule = "fixed";
  }
  return bound;
}

}  // namespace physmas::bind
