#include "candidate/transforms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "records/screen.h"
#include "records/support.h"

namespace physmas::candidate {
namespace {

constexpr double kSupportRho = 1000;       // kg/m^3, lower bound
constexpr double kSupportNu = 0.35;        // upper bound
constexpr double kBondedRho = 2500;        // kg/m^3
constexpr double kBondedEta = 0.85;        // support-shape weight of hard-support bonded
constexpr double kCohesiveE = 5e5;         // Pa, lower bound of the cohesion repairs
constexpr double kCohesiveRho = 500;       // kg/m^3, lower bound of the cohesion repairs
constexpr double kAlternativeP = 0.12;     // least posterior of the second label
constexpr double kAlternativeE = 1e7;      // Pa
constexpr double kAlternativeFactor = 10;  // over E_post

bool is_cohesive_branch(Branch branch) {
  return branch == Branch::foam || branch == Branch::plasticine || branch == Branch::jelly;
}

bool any(const Context& context, const std::function<bool(const ActiveRow&)>& test) {
  return std::any_of(context.active.begin(), context.active.end(), test);
}

bool has_support(const Context& context) {
  return any(context, [](const ActiveRow& a) { return a.support; });
}

bool has_support_and_cohesive(const Context& context) {
  return has_support(context) && any(context, [](const ActiveRow& a) { return !a.support && a.cohesive; });
}

// A configuration whose rows come from `make`, without controls.
Configuration for_rows(const Context& context, const std::function<CandidateRow(const ActiveRow&)>& make) {
  Configuration configuration;
  for (const ActiveRow& a : context.active) configuration.rows.push_back(make(a));
  return configuration;
}

Configuration at_quantiles(const Context& context, double kappa_E, double kappa_nu) {
  return for_rows(context, [&](const ActiveRow& a) { return row_at(context, a, kappa_E, kappa_nu); });
}

CandidateRow median_row(const Context& context, const ActiveRow& a) {
  return row_at(context, a, kMedian, kMedian);
}

CandidateRow impact_row(const Context& context, const ActiveRow& a) {
  CandidateRow row = median_row(context, a);
  if (!a.target) return row;
  if (a.support) {
    row.branch = Branch::metal;
    row.E = kSupportE;
    row.nu = std::clamp(row.nu, 0.05, 0.35);
    row.rho = std::max(row.rho, kSupportRho);
  } else if (a.cohesive && !row.residual) {
    row.E = std::clamp(row.E, 2e4, 7.5e4);
    if (!is_cohesive_branch(row.branch)) row.branch = Branch::foam;
    row.nu = std::clamp(row.nu, 0.2, 0.4);
    row.rho = std::min(450.0, std::max(300.0, row.rho));
  }
  return row;
}

double whole_object_nu(const Context& context) {
  return std::clamp(context.evidence.whole_object.nu, 0.2, 0.485);
}

CandidateRow bonded_row(const Context& context, const ActiveRow& a) {
  const WholeObject& whole = context.evidence.whole_object;
  CandidateRow row = median_row(context, a);
  if (a.support) {
    row.branch = Branch::metal;
    row.E = kSupportE;
    row.nu = kSupportNu;
    row.rho = kBondedRho;
  } else {
    row.branch = Branch::plasticine;
    row.E = std::max(row.E, a.weight * whole.E);
    row.nu = whole_object_nu(context);
    row.rho = whole.rho;
  }
  return row;
}

CandidateRow compatible_row(const Context& context, const ActiveRow& a) {
  const WholeObject& whole = context.evidence.whole_object;
  CandidateRow row = median_row(context, a);
  row.branch = is_cohesive_branch(whole.branch) ? whole.branch : Branch::plasticine;
  row.E = std::clamp(a.weight * whole.E, 0.85 * whole.E, 1.7 * whole.E);
  row.nu = whole_object_nu(context);
  row.rho = whole.rho;
  return row;
}

// The second label of the stored posterior order, and whether the row may take it.
int second_label(const EvidenceRow& row) {
  return row.posterior[1].first;
}

bool is_alternative_feasible(const EvidenceRow& row) {
  const double E_limit = std::max(kAlternativeFactor * std::pow(10.0, row.log10_E), kAlternativeE);
  return row.posterior[1].second >= kAlternativeP && kLabels[second_label(row)].E_default() <= E_limit;
}

using Built = std::optional<Configuration>;

Built target_impact(const Context& context, std::string& why) {
  if (!any(context, [](const ActiveRow& a) { return a.target; })) {
    why = "no action of the plan hits an active target row with an impact";
    return std::nullopt;
  }
  const auto softens = [&](const ActiveRow& a) {
    return a.target && !a.support && a.cohesive && !context.inventory_row(a).residual;
  };
  if (!any(context, softens)) {
    why = "no semantic target row with S = 0 and C = 1";
    return std::nullopt;
  }
  return for_rows(context, [&](const ActiveRow& a) { return impact_row(context, a); });
}

Built hard_support_bonded(const Context& context, std::string& why) {
  if (!has_support_and_cohesive(context)) {
    why = "it needs a row with S = 1 and another with S = 0 and C = 1";
    return std::nullopt;
  }
  Configuration configuration = for_rows(context, [&](const ActiveRow& a) { return bonded_row(context, a); });
  for (const ActiveRow& a : context.active) {
    if (!a.support) continue;
    configuration.projection.emplace_back(context.inventory_row(a).key(), kBondedEta);
    // Objects of a multi-object scene meet on the grid only.
    if (!context.several_objects) configuration.retention.push_back(context.inventory_row(a).key());
  }
  return configuration;
}

Built support_stiff(const Context& context, std::string& why) {
  if (!has_support(context)) {
    why = "no row with S = 1";
    return std::nullopt;
  }
  return for_rows(context, [&](const ActiveRow& a) {
    const CandidateRow row = median_row(context, a);
    return a.support ? stiff_support(row) : row;
  });
}

Built solver_compatible(const Context& context, std::string& why) {
  if (!has_support_and_cohesive(context)) {
    why = "it needs a row with S = 1 and another with S = 0 and C = 1";
    return std::nullopt;
  }
  return for_rows(context, [&](const ActiveRow& a) { return compatible_row(context, a); });
}

Built rigid_support(const Context& context, std::string& why) {
  if (!has_support(context)) {
    why = "no row with S = 1";
    return std::nullopt;
  }
  Configuration configuration = at_quantiles(context, kQuantile25, kQuantile75);
  for (size_t i = 0; i < context.active.size(); ++i) {
    if (!context.active[i].support) continue;
    configuration.rows[i].E = kSupportE;
    configuration.projection.emplace_back(configuration.rows[i].key, 1.0);
  }
  return configuration;
}

Built uncertainty_sweep(const Context& context, std::string& why) {
  const ActiveRow* weakest = nullptr;
  for (const ActiveRow& a : context.active) {
    if (context.inventory_row(a).residual) continue;
    if (weakest == nullptr ||
        context.evidence_row(a).part_confidence < context.evidence_row(*weakest).part_confidence) {
      weakest = &a;
    }
  }
  if (weakest == nullptr) {
    why = "no semantic row";
    return std::nullopt;
  }
  return for_rows(context, [&](const ActiveRow& a) {
    return row_at(context, a, a.row == weakest->row ? kQuantile15 : kMedian, kQuantile75);
  });
}

Built alternative_material(const Context& context, std::string& why) {
  const ActiveRow* chosen = nullptr;
  for (const ActiveRow& a : context.active) {
    const EvidenceRow& row = context.evidence_row(a);
    if (!is_alternative_feasible(row)) continue;
    if (chosen == nullptr || row.posterior[1].second > context.evidence_row(*chosen).posterior[1].second) chosen = &a;
  }
  if (chosen == nullptr) {
    why = "no row has a feasible second label";
    return std::nullopt;
  }
  return for_rows(context, [&](const ActiveRow& a) {
    const EvidenceRow& row = context.evidence_row(a);
    const bool changes = a.row == chosen->row && second_label(row) != row.label;
    return changes ? row_of_label(context, a, second_label(row)) : median_row(context, a);
  });
}

CandidateRow elastic_cohesion(CandidateRow row) {
  row.branch = Branch::jelly;
  row.E = std::max(row.E, kCohesiveE);
  row.nu = std::clamp(row.nu, 0.2, 0.42);
  row.rho = std::max(row.rho, kCohesiveRho);
  return row;
}

CandidateRow higher_cohesion(CandidateRow row) {
  row.E = std::max(row.E, kCohesiveE);
  row.rho = std::max(row.rho, kCohesiveRho);
  return row;
}

CandidateRow stabilised(CandidateRow row) {
  row.nu = std::min(row.nu, 0.40);
  row.rho = std::max(row.rho, 300.0);
  return row;
}

// One row of a repair; S-hat and C-hat are the evaluator's, on the base.
CandidateRow repaired_row(const std::string& name, const CandidateRow& row, bool support, bool cohesive) {
  if (name == "solver-stability") return stabilised(row);
  if (support) return stiff_support(row);
  if (!cohesive) return row;
  if (name == "elastic-cohesion") return elastic_cohesion(row);
  if (name == "higher-cohesion") return higher_cohesion(row);
  const bool yields = row.branch == Branch::foam || row.branch == Branch::plasticine;
  if (name == "role-balanced" && yields) return elastic_cohesion(row);
  return row;
}

// Sets the weight of a row, keeping row order among the rows of the configuration.
void set_projection(Configuration& configuration, const std::string& key, double eta) {
  std::map<std::string, double> weights(configuration.projection.begin(), configuration.projection.end());
  weights[key] = eta;
  configuration.projection.clear();
  for (const CandidateRow& row : configuration.rows) {
    const auto weight = weights.find(row.key);
    if (weight != weights.end()) configuration.projection.emplace_back(*weight);
  }
}

}  // namespace

CandidateRow stiff_support(CandidateRow row) {
  row.branch = Branch::metal;
  row.E = kSupportE;
  row.nu = std::min(row.nu, kSupportNu);
  row.rho = std::max(row.rho, kSupportRho);
  return row;
}

void keep_stated(const Context& context, Configuration& configuration) {
  for (CandidateRow& row : configuration.rows) {
    const StatedMaterial& stated = context.evidence.rows[row.row].stated;
    if (stated.label) {
      row.label = *stated.label;
      row.branch = kLabels[*stated.label].branch;
    }
    row.E = stated.E.value_or(row.E);
    row.nu = stated.nu.value_or(row.nu);
    row.rho = stated.rho.value_or(row.rho);
  }
}

bool operator==(const Configuration& a, const Configuration& b) {
  const auto same_row = [](const CandidateRow& x, const CandidateRow& y) {
    return x.key == y.key && x.branch == y.branch && x.E == y.E && x.nu == y.nu && x.rho == y.rho && x.label == y.label;
  };
  return a.projection == b.projection && a.retention == b.retention &&
         std::equal(a.rows.begin(), a.rows.end(), b.rows.begin(), b.rows.end(), same_row);
}

Configuration configuration_of(const Candidate& candidate) {
  return {candidate.rows, candidate.projection, candidate.retention};
}

std::optional<Configuration> transform(const Context& context, const std::string& name, std::string& why) {
  if (name == "posterior") return at_quantiles(context, kMedian, kMedian);
  if (name == "target-impact") return target_impact(context, why);
  if (name == "hard-support-bonded") return hard_support_bonded(context, why);
  if (name == "support-stiff") return support_stiff(context, why);
  if (name == "solver-compatible") return solver_compatible(context, why);
  if (name == "rigid-support") return rigid_support(context, why);
  if (name == "soft") return at_quantiles(context, kQuantile25, kQuantile75);
  if (name == "stiff") return at_quantiles(context, kQuantile75, kMedian);
  if (name == "uncertainty-sweep") return uncertainty_sweep(context, why);
  if (name == "alternative-material") return alternative_material(context, why);
  throw internal_error("no transform named " + name);
}

Configuration repair(const Context& context, const std::string& name, const Candidate& base) {
  if (std::find(kRepairNames.begin(), kRepairNames.end(), name) == kRepairNames.end())
    throw internal_error("no repair named " + name);
  Configuration configuration = configuration_of(base);
  for (CandidateRow& row : configuration.rows) {
    const InventoryRow& part = context.inventory.rows[row.row];
    const bool support = evaluator_support(part, row), cohesive = evaluator_cohesive(part, row);
    row = repaired_row(name, row, support, cohesive);
    if (name == "rigid-support" && support) set_projection(configuration, row.key, 1.0);
  }
  return configuration;
}

}  // namespace physmas::candidate
