#include "candidate/context.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "candidate/stiffness_weight.h"
#include "records/support.h"

namespace physmas::candidate {
namespace {

CandidateRow clamped(CandidateRow row) {
  row.nu = std::clamp(row.nu, kSolverNu[0], kSolverNu[1]);
  row.rho = std::clamp(row.rho, kSolverRho[0], kSolverRho[1]);
  return row;
}

std::set<int> impact_rows(const Inventory& inventory, const Plan& plan) {
  std::set<int> rows;
  for (const PlanAction& action : plan.actions) {
    if (!action.impact || action.role != "target") continue;
    for (int r : resolve_rows(inventory, action.target)) rows.insert(r);
  }
  return rows;
}

}  // namespace

Context make_context(const Inventory& inventory, const Evidence& evidence, const Plan& plan,
                     const RunSpecification& run, const std::vector<long>& gaussians, const State* state) {
  Context context{inventory, evidence, plan, run, {}, {}, false, 0, state};
  const std::set<int> targets = impact_rows(inventory, plan);
  std::set<std::string> objects;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const InventoryRow& row = inventory.rows[r];
    if (row.residual && gaussians[r] == 0) {
      context.inactive.push_back({"row " + row.key(), "a residual row without Gaussians"});
      continue;
    }
    const int label = evidence.rows[r].label;
    const bool support = construction_support(row, label);
    context.active.push_back({static_cast<int>(r), support, construction_cohesive(row, label),
                              stiffness_weight(row, support), targets.count(static_cast<int>(r)) > 0});
    objects.insert(row.object);
    context.mean_part_confidence += evidence.rows[r].part_confidence;
  }
  if (context.active.empty()) {
    throw invalid_input({"", "part table", "no active row", "a semantic row, or a residual row with Gaussians"});
  }
  context.mean_part_confidence /= static_cast<double>(context.active.size());
  context.several_objects = objects.size() > 1;
  return context;
}

double E_at(const EvidenceRow& row, double kappa) {
  return kLabels[row.label].clip_E(std::pow(10.0, row.log10_E + kappa * row.E_dispersion));
}

double nu_at(const EvidenceRow& row, double kappa) {
  return kLabels[row.label].clip_nu(row.nu + kappa * row.nu_dispersion);
}

CandidateRow row_at(const Context& context, const ActiveRow& a, double kappa_E, double kappa_nu) {
  const EvidenceRow& evidence = context.evidence_row(a);
  CandidateRow row = row_of_label(context, a, evidence.label);
  row.E = E_at(evidence, kappa_E);
  row.nu = nu_at(evidence, kappa_nu);
  if (evidence.field) row.rho = evidence.field->rho.median;
  return clamped(row);
}

CandidateRow row_of_label(const Context& context, const ActiveRow& a, int label) {
  const LabelPrior& prior = kLabels[label];
  CandidateRow row;
  row.key = context.inventory_row(a).key();
  row.row = a.row;
  row.branch = prior.branch;
  row.E = prior.E_default();
  row.nu = prior.nu_default();
  row.rho = prior.rho;
  row.label = label;
  row.residual = context.inventory_row(a).residual;
  const std::optional<EvidenceRow::Field>& field = context.evidence_row(a).field;
  if (field) row.field = {{field->E.median, field->nu.median, field->rho.median}, context.evidence_row(a).label};
  return clamped(row);
}

}  // namespace physmas::candidate
