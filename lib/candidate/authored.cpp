#include "candidate/authored.h"

#include <algorithm>

#include "candidate/context.h"
#include "candidate/schedule.h"
#include "candidate/timestep.h"

namespace physmas::candidate {
namespace {

// A label whose branch it is: what the predicates of supports see.
int label_of(Branch branch) {
  const auto found =
      std::find_if(kLabels.begin(), kLabels.end(), [&](const LabelPrior& l) { return l.branch == branch; });
  return static_cast<int>(found - kLabels.begin());
}

}  // namespace

Candidate authored_candidate(const AuthoredConfiguration& configuration, const Inventory& inventory,
                             const RunSpecification& run, const std::vector<long>& gaussians, const std::string& file) {
  Evidence evidence;
  evidence.rows.resize(inventory.rows.size());
  for (EvidenceRow& row : evidence.rows) row.label = kPlastic;
  for (const AuthoredRow& row : configuration.rows) evidence.rows[row.row].label = label_of(row.branch);
  Plan plan;
  plan.actions = configuration.actions;
  const Context context = make_context(inventory, evidence, plan, run, gaussians);

  Configuration executable;
  for (const ActiveRow& a : context.active) {
    executable.rows.push_back(row_of_label(context, a, context.evidence_row(a).label));
    const auto authored = std::find_if(configuration.rows.begin(), configuration.rows.end(),
                                       [&](const AuthoredRow& row) { return row.row == a.row; });
    if (authored == configuration.rows.end()) continue;
    CandidateRow& row = executable.rows.back();
    row.branch = authored->branch;
    row.E = authored->E, row.nu = authored->nu, row.rho = authored->rho;
  }
  Candidate candidate;
  candidate.id = candidate.transform = "authored";
  candidate.base_confidence = 1;
  candidate.timestep = step_size(executable.rows, evidence.whole_object, run.time, run.grid.length / run.grid.n);
  candidate.omitted = context.inactive;
  candidate.schedule = compile_schedule(context, executable, candidate.timestep, file, candidate.omitted);
  candidate.rows = std::move(executable.rows);
  return candidate;
}

}  // namespace physmas::candidate
