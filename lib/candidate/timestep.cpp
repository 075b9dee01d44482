#include "candidate/timestep.h"

#include <algorithm>
#include <cmath>

#include "base/elasticity.h"
#include "records/particle_material.h"

namespace physmas::candidate {
namespace {

constexpr double kReferenceE = 5e6, kReferenceNu = 0.35, kReferenceRho = 2500;
constexpr double kWaveSpeedScale = 0.7;  // kappa_CFL
// Quotients such as 0.04 / 2e-4 must not gain or lose a substep to rounding.
constexpr double kSlack = 1e-9;

// Wave speed of the fastest particle with a material of its own, 0 where there is none.
double fastest_particle(const std::vector<CandidateRow>& rows, const State& state) {
  if (state.field.empty()) return 0;
  std::vector<const CandidateRow*> row_of(state.row_keys.size(), nullptr);
  for (const CandidateRow& row : rows) {
    if (row.field) row_of[row.row] = &row;
  }
  double fastest = 0;
  for (size_t q = 0; q < state.particle_count(); ++q) {
    const CandidateRow* row = row_of[state.row[q]];
    if (row == nullptr) continue;
    const ParticleNumbers own = particle_numbers(*row, state.field, q);
    fastest = std::max(fastest, wave_speed(own.E, own.nu, own.rho));
  }
  return fastest;
}

}  // namespace

TimestepResult step_size(const std::vector<CandidateRow>& rows, const WholeObject& whole,
                         const RunSpecification::Time& time, double dx, const State* state) {
  TimestepResult result;
  // As the solver decides it (lib/mpm/rigid/stiff_rows.cpp): 0.7 of the stable step against a third of the step.
  const auto counted = [&](double speed) {
    return time.stiff == "off" || 0.7 * dx / speed >= time.substep_dt / 3 ? speed : 0;
  };
  result.c_max = counted(wave_speed(whole.E, whole.nu, whole.rho));
  for (const CandidateRow& row : rows) {
    const bool yields = row.branch != Branch::jelly && row.branch != Branch::metal;
    const double speed = wave_speed(row.E, row.nu, row.rho);
    result.c_max = std::max(result.c_max, yields ? speed : counted(speed));
  }
  if (state != nullptr) result.c_max = std::max(result.c_max, counted(fastest_particle(rows, *state)));
  result.c_ref = wave_speed(kReferenceE, kReferenceNu, kReferenceRho);
  result.target = result.c_max <= kWaveSpeedScale * result.c_ref
                      ? time.substep_dt
                      : kWaveSpeedScale * time.substep_dt * result.c_ref / result.c_max;
  // Counts stay doubles until the caps have made them small.
  double substeps = std::max(1.0, std::ceil(time.frame_dt / result.target * (1 - kSlack)));
  const double most = std::max(1.0, std::floor(time.frame_dt / time.min_substep_dt * (1 + kSlack)));
  if (substeps > most) {
    substeps = most;
    result.capped_by = "min_substep_dt";
  }
  if (substeps > time.max_substeps) {
    substeps = time.max_substeps;
    result.capped_by = "max_substeps";
  }
  result.substeps = static_cast<int>(substeps);
  result.dt = time.frame_dt / result.substeps;
  return result;
}

}  // namespace physmas::candidate
