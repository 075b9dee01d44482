#include "records/support.h"

#include <algorithm>
#include <set>

#include "records/text_match.h"

namespace physmas {
namespace {

using Tokens = std::vector<const char*>;

// The guard; "load" with "bearing" as well.
const Tokens kGuardStructural = {"support", "supporting", "structural", "rigid", "loadbearing"};

const Tokens kConstructionSupport = {"plate",      "dish",  "tray",         "stand",        "support", "holder",
                                     "structural", "rigid", "load bearing", "load-bearing", "frame",   "shell",
                                     "blade",      "head",  "tip",          "impact part"};
const Tokens kConstructionSoft = {"soft",  "deformable", "compressible", "cushion", "foam",     "sponge", "flesh",
                                  "fruit", "food",       "filling",      "cream",   "frosting", "icing"};
const Tokens kConstructionCohesive = {"body",    "base",  "core",       "main",     "bulk",   "filling",
                                      "coating", "layer", "cream",      "frosting", "icing",  "fruit",
                                      "organic", "soft",  "deformable", "foam",     "sponge", "rubber",
                                      "gel",     "cloth", "fabric",     "leather",  "pad"};

const Tokens kEvaluatorSupport = {"plate", "dish",   "tray", "bowl",  "base support", "support",
                                  "stand", "holder", "case", "shell", "frame"};
const Tokens kEvaluatorCohesive = {"body",    "base", "core", "filling", "cream",  "frosting", "icing", "soft",
                                   "cushion", "pad",  "foam", "sponge",  "rubber", "gel",      "fruit", "food"};

// Name, physics group and role, then what may follow.
RowText text_of(const InventoryRow& row) {
  return row_text(row, {row.name, row.physics_group, row.structural_role});
}
RowText text_of(const InventoryRow& row, int label) {
  return row_text(row, {row.name, row.physics_group, row.structural_role, kLabels[label].name});
}

// What both cohesion predicates say where no token decides.
bool is_cohesive_matter(Branch branch, int label) {
  return (branch == Branch::foam || branch == Branch::plasticine || branch == Branch::jelly) && !is_rigid_label(label);
}

}  // namespace

bool guard_structural(const InventoryRow& row) {
  const std::set<std::string> words = words_of(match_text({row.physics_group, row.structural_role}));
  if (words.count("load") > 0 && words.count("bearing") > 0) return true;
  return std::any_of(kGuardStructural.begin(), kGuardStructural.end(),
                     [&](const char* word) { return words.count(word) > 0; });
}

bool construction_support(const InventoryRow& row, int label) {
  const RowText text = text_of(row);
  if (contains_any(text, kConstructionSupport)) return true;
  if (contains_any(text, kConstructionSoft)) return false;
  return is_rigid_label(label);
}

bool construction_cohesive(const InventoryRow& row, int label) {
  if (construction_support(row, label)) return false;
  return contains_any(text_of(row, label), kConstructionCohesive) || is_cohesive_matter(kLabels[label].branch, label);
}

bool evaluator_support(const InventoryRow& row, const CandidateRow& candidate) {
  return contains_any(row_text(row, {row.name}), kEvaluatorSupport) || is_rigid_label(candidate.label);
}

bool evaluator_cohesive(const InventoryRow& row, const CandidateRow& candidate) {
  if (evaluator_support(row, candidate)) return false;
  if (candidate.branch == Branch::sand || candidate.branch == Branch::snow) return false;
  return contains_any(text_of(row, candidate.label), kEvaluatorCohesive) ||
         is_cohesive_matter(candidate.branch, candidate.label);
}

}  // namespace physmas
