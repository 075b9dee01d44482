#include "bind/execution.h"

#include <fmt/format.h>

#include <cmath>

#include "base/clock.h"
#include "bind/divergence.h"
#include "bind/rollout.h"
#include "bind/vector.h"

namespace physmas::bind {
namespace {

double if_finite(double x) {
  return std::isfinite(x) ? x : 0;
}

// The terms of the energy budget per output frame, as the record names them.
std::vector<std::pair<std::string, std::vector<double>>> energy_terms(const std::vector<mpm::Balance>& balances,
                                                                      bool some_rigid) {
  using Budget = mpm::EnergyBudget;
  const std::pair<const char*, double Budget::*> terms[] = {
      {"change", &Budget::change},   {"transfer", &Budget::transfer},   {"contact", &Budget::contact},
      {"plastic", &Budget::plastic}, {"viscous", &Budget::viscous},     {"projection", &Budget::projection},
      {"control", &Budget::control}, {"structure", &Budget::structure}, {"rigid", &Budget::rigid}};
  std::vector<std::pair<std::string, std::vector<double>>> list;
  for (const auto& [name, term] : terms) {
    if (term == &Budget::rigid && !some_rigid) continue;
    list.emplace_back(name, std::vector<double>{});
    for (const mpm::Balance& balance : balances) list.back().second.push_back(balance.budget.*term);
  }
  list.emplace_back("residual", std::vector<double>{});
  for (const mpm::Balance& balance : balances) list.back().second.push_back(balance.budget.residual());
  return list;
}

void record_status(const mpm::Options& options, const mpm::Result& result, ExecutionRecord& record) {
  record.diverged = result.status == mpm::Status::diverged;
  if (record.diverged) {
    record.error_tokens.push_back(result.reason);
    record.reason = result.reason == "budget"
                        ? fmt::format("more than {} substeps, which --max-steps allows", options.max_steps)
                        : fmt::format("{} in substep {}", result.reason, result.first_bad_step);
  }
  record.first_bad_step = static_cast<long>(result.first_bad_step);
  record.max_speed = if_finite(result.max_speed);
  record.J_min = result.min_J;
  record.J_max = result.max_J;
  record.particles_outside = static_cast<long>(result.particles_outside);
}

void record_balances(const mpm::Options& options, const mpm::Result& result, ExecutionRecord& record) {
  record.mass = result.balances.front().mass;
  record.momentum_start = from_mpm(result.balances.front().momentum);
  record.momentum_end = from_mpm(result.balances.back().momentum);
  for (const mpm::Balance& balance : result.balances) {
    record.kinetic.push_back(balance.kinetic);
    if (result.measured_energy) record.elastic.push_back(balance.elastic);
    record.potential.push_back(balance.gravity);
  }
  record.energy_measured = options.measure_steps ? "steps" : options.measure_energy ? "frames" : "off";
  const mpm::EnergyResidual residual = mpm::energy_residual(result);
  record.energy_residual = if_finite(residual.joules);
  record.energy_scale = if_finite(residual.scale);
  if (result.measured_steps) {
    record.largest_step_residual = result.balances.back().budget.largest_step_residual;
    record.energy_terms = energy_terms(result.balances, !result.rigid_bodies.empty());
  }
}

void record_steps(const BoundTiming& timing, const mpm::Result& result, ExecutionRecord& record) {
  record.substeps_per_frame = timing.timing.substeps;
  record.step_rule = timing.rule;
  record.smallest_dt = result.history.smallest_dt;
  record.largest_dt = result.history.largest_dt;
  record.retries = static_cast<long>(result.history.retries);
  record.discarded_steps = static_cast<long>(result.history.discarded_steps);
  record.steps = static_cast<long>(result.steps);
  record.dt = result.dt;
  record.frames = result.frames_done;
}

void record_stiff(const Candidate& candidate, const mpm::Result& result, ExecutionRecord& record) {
  const auto key = [&](int row) {
    for (const CandidateRow& r : candidate.rows)
      if (r.row == row) return r.key;
    throw internal_error("a stiff row that the candidate does not have");
  };
  for (const mpm::StiffRow& row : result.stiff_rows) {
    record.stiff_rows.push_back({key(row.row), row.rigid, row.why, row.limit, if_finite(row.deflection), row.bodies});
  }
  for (const mpm::RigidBodyReport& body : result.rigid_bodies) {
    RigidBodyRecord& of = record.rigid_bodies.emplace_back();
    for (const int row : body.rows) of.rows.push_back(key(row));
    of.mass = body.mass;
    of.impacts = static_cast<long>(body.impacts);
    of.restitution = body.restitution;
    of.largest_acceleration = if_finite(body.largest_acceleration);
    of.largest_jump = if_finite(body.largest_jump);
    of.error = if_finite(body.error);
  }
  record.impacts = {static_cast<long>(result.impacts.windows), static_cast<long>(result.impacts.steps),
                    static_cast<long>(result.impacts.small_steps)};
}

Json runtime_of(const mpm::Result& result) {
  return {{"seconds",
           {{"total", result.seconds_total},
            {"particles", result.seconds_particles},
            {"grid", result.seconds_grid},
            {"sort", result.seconds_sort},
            {"frames", result.seconds_frames}}},
          {"particle_steps_per_second", result.particle_steps_per_second},
          {"threads", result.threads},
          {"solver_particle_bytes", result.particle_bytes},
          {"solver_grid_bytes", result.grid_bytes},
          {"peak_memory_bytes", peak_memory_bytes()}};
}

}  // namespace

ExecutionRecord execution_record(const Candidate& candidate, const mpm::Problem& problem, const BoundTiming& timing,
                                 const mpm::Options& options, const mpm::Result& result) {
  ExecutionRecord record;
  record.candidate = candidate.id;
  record_status(options, result, record);
  if (record.diverged) record.divergence = explain_divergence(candidate, problem, timing, options, result);
  record_balances(options, result, record);
  record_steps(timing, result, record);
  record_stiff(candidate, result, record);
  record.particles = static_cast<long>(problem.particles.size());
  record.grid = {{"n", problem.domain.n}, {"length", problem.domain.length}};
  record.precision = options.precision == mpm::Precision::full ? "double" : "float";
  record.deformation = deformation_name(options);
  for (const mpm::Omission& omission : result.omitted) record.omitted.push_back({omission.what, omission.why});
  record.runtime = runtime_of(result);
  return record;
}

ExecutionRecord with_retry(const ExecutionRecord& first, long long first_allowed, const ExecutionRecord& second,
                           long long second_allowed) {
  ExecutionRecord record = second.diverged ? first : second;
  const auto add = [&](const ExecutionRecord& r, long long allowed) {
    record.attempts.push_back({r.step_rule, r.diverged, r.reason, r.frames, r.steps, static_cast<long>(allowed)});
  };
  add(first, first_allowed);
  add(second, second_allowed);
  if (second.divergence && second.divergence->cause == "budget")
    record.attempts.back().reason =
        fmt::format("more than {} substeps, which time.retry_substeps allows", second_allowed);
  if (second.diverged) {
    record.divergence->advice =
        second.divergence->cause == "budget"
            ? first.divergence->advice +
                  fmt::format("; by itself it was not tried beyond the {} substeps of time.retry_substeps",
                              second_allowed)
            : second.divergence->advice;
  }
  return record;
}

}  // namespace physmas::bind
