// What all candidates of a scene are built from.
#ifndef PHYSMAS_CANDIDATE_CONTEXT_H
#define PHYSMAS_CANDIDATE_CONTEXT_H

#include <string>
#include <vector>

#include "records/candidate.h"
#include "records/evidence.h"
#include "records/inventory.h"
#include "records/plan.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::candidate {

// An active row with its construction predicates.
struct ActiveRow {
  int row = 0;  // index in inventory.rows
  bool support = false;
  bool cohesive = false;
  double weight = 1;    // omega
  bool target = false;  // an impact of the plan hits it
};

struct Context {
  const Inventory& inventory;
  const Evidence& evidence;
  const Plan& plan;
  const RunSpecification& run;
  std::vector<ActiveRow> active;    // inventory order
  std::vector<Omission> inactive;   // residual rows without Gaussians
  bool several_objects = false;     // two or more objects among the active rows
  double mean_part_confidence = 0;  // gamma-bar over the active rows
  const State* state = nullptr;     // where its particles have materials of their own

  const InventoryRow& inventory_row(const ActiveRow& a) const { return inventory.rows[a.row]; }
  const EvidenceRow& evidence_row(const ActiveRow& a) const { return evidence.rows[a.row]; }
};

// gaussians: how many carry each row, [inventory.rows]. Active are all semantic rows, and residual rows with Gaussians;
// an empty part table is an Error (exit code 3). The references, and `state` where it is not null, must outlive the
// context.
Context make_context(const Inventory& inventory, const Evidence& evidence, const Plan& plan,
                     const RunSpecification& run, const std::vector<long>& gaussians, const State* state = nullptr);

// The standard normal quantiles that the transforms use: kappa_xi for xi = 0.15, 0.25, 0.50, 0.75.
constexpr double kQuantile15 = -1.04, kQuantile25 = -0.67, kMedian = 0, kQuantile75 = 0.67;

// E_r(xi) [Pa] and nu_r(xi) of Eq. quantile, inside the domain of the row's label.
double E_at(const EvidenceRow& row, double kappa);
double nu_at(const EvidenceRow& row, double kappa);

// The ordinary solver row of a: Map(m_r), the quantiles, the label's density; nu in [0.05, 0.45], rho in [300, 3000].
CandidateRow row_at(const Context& context, const ActiveRow& a, double kappa_E, double kappa_nu);
// The row with another visual label and that label's defaults, under the same clamps.
CandidateRow row_of_label(const Context& context, const ActiveRow& a, int label);

}  // namespace physmas::candidate

#endif
