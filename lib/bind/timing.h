// The output frames of a run, and the substeps between them.
#ifndef PHYSMAS_BIND_TIMING_H
#define PHYSMAS_BIND_TIMING_H

#include <string>

#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/run_specification.h"

namespace physmas::bind {

struct BoundTiming {
  mpm::Timing timing;
  std::string rule;  // as the execution record names it: paper, cfl or fixed
};

// time.stiff of the run specification.
mpm::StiffRule bind_stiff_rule(const std::string& rule);

// The fewest substeps of a frame that are no longer than dt [s].
int whole_substeps(double dt, double frame_dt);

// rule: "paper" (the candidate's substeps), "cfl" (its largest step is the base step; the candidate's is ignored) or a
// number of seconds, which is made a little shorter until it divides the frame. file: the candidate's, for errors.
// Throws an Error: exit code 3 when the candidate's substeps do not fill a frame, 2 when the rule is none of these.
BoundTiming bind_timing(const std::string& rule, const RunSpecification::Time& time, const Candidate& candidate,
                        const std::string& file);

}  // namespace physmas::bind

#endif
