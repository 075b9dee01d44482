// Which rows are supports, and which cohesive, for each of the three that ask.
#include "records/support.h"

#include <doctest/doctest.h>

using namespace physmas;

namespace {

InventoryRow part(const std::string& name, const std::string& group = "", const std::string& role = "") {
  InventoryRow row;
  row.name = name;
  row.physics_group = group;
  row.structural_role = role;
  return row;
}

CandidateRow of_label(int label, Branch branch) {
  CandidateRow row;
  row.label = label;
  row.branch = branch;
  return row;
}

}  // namespace

TEST_CASE("records: construction's predicates and their precedence") {
  CHECK(construction_support(part("Tray"), kFoam));
  CHECK(construction_support(part("x", "load_bearing"), kFoam));
  CHECK(construction_support(part("x", "", "impact part"), kFoam));
  CHECK(construction_support(part("soft plate"), kFoam));    // support before soft
  CHECK_FALSE(construction_support(part("fruit"), kStone));  // soft before the label
  CHECK(construction_support(part("thing"), kGlass));
  CHECK_FALSE(construction_support(part("thing"), kPlastic));
  CHECK_FALSE(construction_cohesive(part("plate body"), kFoam));
  CHECK(construction_cohesive(part("thing", "coating"), kPlastic));
  CHECK(construction_cohesive(part("thing"), kRubber));  // "rubber" is in the visual label
  CHECK(construction_cohesive(part("thing"), kPaper));   // branch Foam
  CHECK_FALSE(construction_cohesive(part("thing"), kSand));
  CHECK(construction_cohesive(part("sand base"), kSand));  // no granular exclusion here
}

TEST_CASE("records: the evaluator's predicates") {
  CandidateRow row;
  row.label = kFoam, row.branch = Branch::foam;
  CHECK(evaluator_support(part("Base_Support"), row));
  CHECK_FALSE(evaluator_support(part("x", "support"), row));  // name only
  CHECK(evaluator_cohesive(part("x", "food"), row));
  row.label = kSand, row.branch = Branch::sand;
  CHECK_FALSE(evaluator_cohesive(part("sand body"), row));
  row.label = kWood, row.branch = Branch::jelly;
  CHECK(evaluator_support(part("x"), row));
  CHECK_FALSE(evaluator_cohesive(part("x body"), row));
  row.label = kPlastic, row.branch = Branch::metal;
  CHECK_FALSE(evaluator_cohesive(part("x"), row));
  CHECK(evaluator_cohesive(part("x core"), row));
}

TEST_CASE("records: the guard matches whole words of group and role") {
  for (const char* word :
       {"support", "supporting", "structural", "rigid", "loadbearing", "load_bearing", "Rigid-body"}) {
    CHECK(guard_structural(part("x", word)));
    CHECK(guard_structural(part("x", "", word)));
    CHECK_FALSE(guard_structural(part(word)));  // the name does not count
  }
  CHECK(guard_structural(part("x", "load", "bearing")));  // pooled over both
  CHECK_FALSE(guard_structural(part("x", "load")));
  CHECK_FALSE(guard_structural(part("x", "", "bearing")));
  CHECK_FALSE(guard_structural(part("x", "unsupported")));  // a substring only
}

TEST_CASE("records: the three say different things of the same row") {
  // A bowl is a support to the evaluator alone.
  CHECK(evaluator_support(part("bowl"), of_label(kFoam, Branch::foam)));
  CHECK_FALSE(construction_support(part("bowl"), kFoam));
  CHECK_FALSE(guard_structural(part("bowl")));
  // A blade to construction alone.
  CHECK(construction_support(part("blade"), kPlastic));
  CHECK_FALSE(evaluator_support(part("blade"), of_label(kPlastic, Branch::metal)));
  // A soft stone ball: no support when candidates are made, one when they are judged.
  CHECK_FALSE(construction_support(part("soft ball"), kStone));
  CHECK(evaluator_support(part("soft ball"), of_label(kStone, Branch::metal)));
  // Granular matter may be cohesive in construction, never to the evaluator.
  CHECK(construction_cohesive(part("sand base"), kSand));
  CHECK_FALSE(evaluator_cohesive(part("sand base"), of_label(kSand, Branch::sand)));
}
