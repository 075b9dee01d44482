// Rows too stiff for the step, advanced as rigid bodies, against resolved runs: `pm-eval stiff`.
#ifndef PHYSMAS_STUDIES_STIFF_STUDY_H
#define PHYSMAS_STUDIES_STIFF_STUDY_H

#include <functional>
#include <string>
#include <vector>

#include "base/device.h"
#include "studies/stiff_cases.h"

namespace physmas::studies {

struct StiffStudyPlan {
  double youngs_modulus = 1.7e10;  // Pa, of the stiff rows
  double dt = 2e-4;                // s: the substep
  double frame_dt = 0.005;         // s: errors are looked for at the frames
  double impact_budget = 1;
  std::string only;  // a case, or all
};

// One scene with one way to advance its stiff rows.
struct StiffOutcome {
  bool diverged = false;
  // Largest over the run: RMS distance from the resolved run over the row's longest extent; of the worst row.
  double stiff_error = 0, other_error = 0;
  double cost = 0;         // seconds of stepping over those of the same scene all soft at the same substep
  double energy_rise = 0;  // largest rise of the total energy between frames over the largest kinetic energy
  long long windows = 0, small_steps = 0, impacts = 0;
  double restitution = -1;  // the largest that was measured
  double error_bound = 0;   // the largest of the bodies, between impacts
};

struct StiffStudy {
  std::string name, text;
  bool held_out = false;
  double goal_stiff = 0, goal_other = 0;
  double resolved_dt = 0;    // s
  double resolved_cost = 0;  // as StiffOutcome::cost
  StiffOutcome rigid;
};

// done: called after each case.
std::vector<StiffStudy> run_stiff_study(const StiffStudyPlan& plan, const Device& device,
                                        const std::function<void()>& done);

std::string stiff_table(const std::vector<StiffStudy>& studies);

}  // namespace physmas::studies

#endif
