// The step that follows the state ("cfl"): bounded by the fastest wave and by the motion of the particles, without a
// cap. Derivation in docs/numerics.md.
#ifndef PHYSMAS_MPM_TIMESTEP_H
#define PHYSMAS_MPM_TIMESTEP_H

#include "mpm/action/schedule.h"
#include "mpm/stepper.h"

namespace physmas::mpm {

class ImpactWindows;

// dt < bounds.wave is the limit of the linearised scheme. Half of the stiffness is left for what changes in a chunk.
constexpr double kWaveShare = 0.7;

// The step chosen for a state: the smallest of `largest`, 0.7 of the wave bound, the time in which the fastest particle
// crosses a fifth of a cell under gravity, and the time in which a velocity gradient strains by 0.3.
double choose_step(const StepBounds& bounds, const Domain& domain, double largest);

// Largest stable step [s] of material at rest, for any arrangement of particles; dx [m].
double rest_limit(const MaterialParameters<double>& parameters, double dx);

// Statistics of a run with adaptive steps.
struct StepHistory {
  double smallest_dt = 0, largest_dt = 0;  // s, of the substeps kept
  double time = 0;                         // s, covered by the substeps kept
  long long steps = 0;                     // substeps kept
  long long retries = 0;                   // chunks done again with a smaller step
  long long discarded_steps = 0;           // substeps of the attempts that were thrown away
};

// Integrates output intervals in chunks of at most 64 substeps. The step is chosen at the start of a chunk from the
// state found there. A chunk whose end no longer admits its step, or that ends with a fault, is thrown away and done
// again with a smaller one, a bounded number of times.
class AdaptiveStepping {
 public:
  // largest_dt [s]: never exceeded; end [s]: when the run ends; max_steps: budget of the run, discarded ones included.
  // windows: for impacts of the stepper's rigid bodies, where it has some; outlives this.
  AdaptiveStepping(const StepperSetup& setup, double largest_dt, double end, long long max_steps,
                   ImpactWindows* windows = nullptr);

  // Advances from time `start` by `duration` [s]. The stepper holds `state`; both hold the end state afterwards, or the
  // last good one when the report names a fault: that of the last attempt, or StepFault::budget when the steps are used
  // up or, at the start of the run, will not suffice at the present step. report.steps counts the substeps kept and,
  // when there is a fault, those up to the faulty one.
  StepReport advance(Stepper& stepper, State& state, const ActionPlan& actions, double start, double duration,
                     double energy_limit);

  const StepHistory& history() const { return history_; }

 private:
  bool admits(const StepBounds& end, const StepReport& report, double dt) const;

  const StepperSetup& setup_;
  double largest_dt_, end_;
  long long max_steps_, steps_done_ = 0;
  ImpactWindows* windows_;
  StepHistory history_;
};

}  // namespace physmas::mpm

#endif
