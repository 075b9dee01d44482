// The candidates of a round, complete with controls, schedule and step size.
#ifndef PHYSMAS_CANDIDATE_BUILD_H
#define PHYSMAS_CANDIDATE_BUILD_H

#include <string>
#include <vector>

#include "candidate/context.h"
#include "records/screen.h"

namespace physmas::candidate {

struct Round {
  int round = 0;
  std::vector<Candidate> candidates;  // fixed order
  std::vector<Omission> omitted;      // transforms that were not emitted or not retained, and why
};

// Round 0: the applicable transforms in the fixed order without duplicates, the first run.screening.initial of them.
// plan_file: for messages about actions.
Round build_initial(const Context& context, const std::string& plan_file);

// The round after `screen`: the routed repairs of its base that are unseen, at most run.screening.repairs. A screen
// that asks for no repair gives an empty round that says why.
// seen: every candidate of the earlier rounds, first appearance first; the base is among them when there is one.
Round build_repairs(const Context& context, const ScreenRecord& screen, const std::vector<Candidate>& seen,
                    const std::string& plan_file);

}  // namespace physmas::candidate

#endif
