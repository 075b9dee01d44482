// Sums and extremes over all particles of a state, in double precision, whatever precision steps work in. They do not
// depend on the number of threads.
#ifndef PHYSMAS_MPM_CPU_STATE_SUMMARY_H
#define PHYSMAS_MPM_CPU_STATE_SUMMARY_H

#include "base/team.h"
#include "mpm/stepper.h"

namespace physmas::mpm {

ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state, Team& team);
// rigid_held: material of rigid bodies bounds no step.
StepBounds measure_bounds(const StepperSetup& setup, const State& state, Team& team, bool rigid_held = false);

}  // namespace physmas::mpm

#endif
