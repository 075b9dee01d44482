// When the actions of a plan act: each at its usual time, or one stage after the other where the prompt tells them so.
#ifndef PHYSMAS_PLAN_TIMETABLE_H
#define PHYSMAS_PLAN_TIMETABLE_H

#include <string>
#include <vector>

#include "plan/prompt.h"
#include "records/plan.h"
#include "records/run_specification.h"

namespace physmas::plan {

class Timetable {
 public:
  explicit Timetable(const RunSpecification& run);

  // What is placed from now on comes after all that was placed before ("then").
  void next_stage();

  // Sets the interval of `action`, in seconds: what the event says, else the table in records/actions.h with `usual` as
  // its length. Returns what had to be changed, as texts for the plan's corrections.
  std::vector<std::string> place(const Event& event, double usual, PlanAction& action);

  // Shortens all stages by one factor where they do not fit into the run. Impulses keep their length, holds that last
  // to the run's end stay.
  void fit(std::vector<PlanAction>& actions);
  double factor() const { return factor_; }  // of fit(): 1 where nothing was shortened

 private:
  double whole_, impulse_;  // s
  double stage_start_ = 0;  // of the stage that is placed
  double latest_end_ = 0;   // of all that was placed, s; beyond the run's end where there are several stages
  double factor_ = 1;
  int stages_ = 1;
  bool empty_stage_ = true;
};

}  // namespace physmas::plan

#endif
