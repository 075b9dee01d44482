// Material evidence: posterior, guards, moments. Golden numbers were computed by hand or by an independent script.
#include "material/evidence.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "material/guards.h"
#include "material/posterior.h"
#include "material/role_lookup.h"
#include "material/statistics.h"

using namespace physmas;
using namespace physmas::material;
using doctest::Approx;

namespace {

InventoryRow make_row(const std::string& name, const std::string& role, const std::string& group,
                      std::vector<std::string> expected) {
  InventoryRow row;
  row.object = "object";
  row.part = "part";
  row.name = name;
  row.structural_role = role;
  row.physics_group = group;
  row.expected_labels = std::move(expected);
  return row;
}

VlmRecord make_vlm(double confidence, std::vector<std::string> views, LabelScores probabilities) {
  VlmRecord record;
  record.success = true;
  record.confidence = confidence;
  record.views = std::move(views);
  record.probabilities = std::move(probabilities);
  return record;
}

const std::vector<std::string> kThreeViews = {"front", "right", "left"};

// A row whose posterior and role lookup are given, so that each guard can be tested by itself.
EvidenceRow guarded(const InventoryRow& row, LabelScores scores, const std::vector<VlmRecord>& vlm) {
  EvidenceRow evidence;
  std::vector<std::string> unknown;
  evidence.expected_labels = canonical_labels(row.expected_labels, unknown);
  evidence.role_lookup = look_up_role(row).maximum;
  evidence.scores = std::move(scores);
  normalise_scores(evidence);
  apply_guards(evidence, row, valid_vlm_records(vlm));
  return evidence;
}

}  // namespace

TEST_CASE("material: role lookup sums matching rules and keeps maxima") {
  // cushion (Foam 0.75) and soft (Foam 0.55, Plasticine 0.35); two words of one rule count once.
  const RoleEvidence role = look_up_role(make_row("Soft_Cushion pad", "", "blade", {}));
  REQUIRE(role.sums.size() == 2);
  CHECK(role.sums[0].first == kFoam);
  CHECK(role.sums[0].second == Approx(1.30));
  CHECK(role.maximum[0].second == Approx(0.75));
  CHECK(role.sums[1].first == kPlasticine);
  CHECK(role.sums[1].second == Approx(0.35));
  // The structural role is scanned, the physics group is not.
  CHECK(look_up_role(make_row("part", "GRIP", "", {})).sums.size() == 2);
  CHECK(look_up_role(make_row("part", "", "tire", {})).sums.empty());
}

TEST_CASE("material: expected labels are canonical, deduplicated, unknown ones dropped before spreading") {
  std::vector<std::string> unknown;
  const auto labels = canonical_labels({"foam", "Velvet", "FOAM", "Wood"}, unknown);
  CHECK(labels == std::vector<int>{kFoam, kWood});
  CHECK(unknown == std::vector<std::string>{"Velvet"});
  const EvidenceRow row = row_evidence(make_row("x", "", "", {"foam", "Velvet", "FOAM", "Wood"}), {}, 1, 0, -1);
  REQUIRE(row.sources.size() == 1);
  CHECK(row.sources[0].second == LabelScores{{kFoam, 0.125}, {kWood, 0.125}});
  // Tie: insertion order, Foam first although Wood precedes it in the table; then the table order.
  CHECK(row.posterior[0].first == kFoam);
  CHECK(row.posterior[1].first == kWood);
  CHECK(row.posterior[2].first == kMetal);
  CHECK(row.label == kFoam);
}

TEST_CASE("material: no evidence falls back to unit Plastic and its defaults") {
  const EvidenceRow row = row_evidence(make_row("thing", "", "", {}), {}, 1, 0, -1);
  CHECK(row.fallback);
  CHECK(row.label == kPlastic);
  CHECK(row.confidence == 1);
  CHECK(row.entropy == 0);
  CHECK(row.log10_E == Approx(std::log10(std::sqrt(1e6 * 5e9))));
  CHECK(row.nu == Approx(0.375));
  // sigma^e = 0.5 * 0.35 + 0.35 * 0.25 = 0.2625; mask unavailable: 0.7 / 1.2625.
  CHECK(row.E_dispersion == Approx(0.2625));
  CHECK(row.nu_dispersion == Approx(0.06));
  CHECK(row.part_confidence == Approx(0.7 / 1.2625));
}

TEST_CASE("material: residual rows skip all sources and guards") {
  InventoryRow row = make_row("blade", "support", "rigid", {"Metal"});
  row.residual = true;
  const EvidenceRow evidence = row_evidence(row, {}, 3, 0, kFoam);
  CHECK(evidence.label == kPlastic);
  CHECK(evidence.sources.empty());
  CHECK(evidence.guards.empty());
  CHECK(evidence.probability(kPlastic) == 1);
}

TEST_CASE("material: golden row with every source (independent script)") {
  // The sponge of tests/data/stages: schema, two crops, one VLM answer, role words, whole-object label Plasticine.
  const InventoryRow row = make_row("Sponge cake", "body", "soft_body", {"Foam", "Plasticine"});
  RowObservations seen;
  CropRecord a, b;
  a.E_mean = -1.0, a.E_uncertainty = 0.3, a.nu_mean = -1.0, a.nu_uncertainty = 0.04;
  a.evidence = {{kFoam, 0.6}, {kPlasticine, 0.2}};
  b.E_mean = -0.8, b.E_uncertainty = 0.5, b.nu_mean = -0.5, b.nu_uncertainty = 0.06;
  b.evidence = {{kFoam, 0.4}, {kRubber, 0.4}};
  seen.crops = {a, b};
  seen.vlm = {make_vlm(0.8, {"front", "right", "back"}, {{kFoam, 3}, {kPlasticine, 1}})};
  const EvidenceRow e = row_evidence(row, seen, 4, 0.9, kPlasticine);
  CHECK(e.probability(kFoam) == Approx(0.535 / 0.91));
  CHECK(e.probability(kPlasticine) == Approx(0.305 / 0.91));
  CHECK(e.probability(kRubber) == Approx(0.07 / 0.91));
  CHECK(e.label == kFoam);
  CHECK(e.E_records == 2);
  CHECK(e.E_mean == Approx(4.12725116).epsilon(1e-9));
  CHECK(e.log10_E == Approx(4.12725116).epsilon(1e-9));
  CHECK(e.E_spread == 0.25);  // the weighted deviation is 0.2407
  CHECK(e.E_uncertainty == Approx(0.4));
  CHECK(e.nu == Approx(0.3092));
  CHECK(e.nu_dispersion == Approx(0.05));
  CHECK(e.entropy == Approx(0.8759693595).epsilon(1e-9));
  CHECK(e.E_dispersion == Approx(0.3372887645).epsilon(1e-9));
  CHECK(e.part_confidence == Approx(0.9 * (0.535 / 0.91) / (1 + e.E_dispersion)));
}

TEST_CASE("material: crops and VLM answers that do not count") {
  const InventoryRow row = make_row("x", "", "", {});
  RowObservations seen;
  CropRecord good, bad;
  good.evidence = {{kWood, 0.5}};
  bad.valid = false;
  bad.E = 1e9, bad.E_uncertainty = 0.1;
  bad.evidence = {{kMetal, 9.0}};
  VlmRecord failed = make_vlm(0.9, kThreeViews, {{kMetal, 1}}), abstained = failed, unsure = failed, empty = failed;
  failed.success = false;
  abstained.abstain = true;
  unsure.confidence.reset();
  empty.probabilities = {{kMetal, 0}};
  seen.crops = {bad, good};
  seen.vlm = {failed, abstained, unsure, empty};
  const EvidenceRow e = row_evidence(row, seen, 1, 0, -1);
  REQUIRE(e.sources.size() == 1);
  CHECK(e.sources[0].second == LabelScores{{kWood, 0.175}});
  CHECK(e.E_records == 0);
  CHECK(e.probability(kWood) == 1);
}

TEST_CASE("material: an E record needs a finite uncertainty, a nu record only nu") {
  CropRecord crop;
  crop.E_mean = 0.0, crop.nu_mean = 0.0;
  EvidenceRow row;
  row.label = kFoam;
  row.confidence = 1;
  pool_statistics(row, {crop});
  CHECK(row.E_records == 0);
  CHECK(row.log10_E == Approx(5.0));  // geometric midpoint of 1e3..1e7
  CHECK(row.nu_records == 1);
  CHECK(row.nu == Approx(0.398));
  CHECK(row.nu_dispersion == Approx(0.06));
  // Eq. decode at zero: 0.1 * 10^7.387210.
  CHECK(*decoded_log10_E(crop) == Approx(6.387210));
  crop.E_mean = 1e6;
  CHECK_FALSE(decoded_log10_E(crop).has_value());
}

TEST_CASE("material: moments are weighted by the selected label's evidence and clamped to its domain") {
  CropRecord a, b, c;
  a.E = 1e4, a.E_uncertainty = 0.2, a.evidence = {{kFoam, 0.3}};
  b.E = 1e6, b.E_uncertainty = 0.2, b.evidence = {{kFoam, 0.01}};    // floored to 0.05
  c.E = 1e12, c.E_uncertainty = 0.5, c.evidence = {{kRubber, 0.9}};  // absent: 0.1
  EvidenceRow row;
  row.label = kFoam;
  row.confidence = 1;
  pool_statistics(row, {a, b, c});
  // (0.3*4 + 0.05*6 + 0.1*12) / 0.45 = 6; variance (0.3*4 + 0 + 0.1*36) / 0.45 = 32/3.
  CHECK(row.E_mean == Approx(6.0));
  CHECK(row.E_spread == Approx(std::sqrt(32.0 / 3)));
  CHECK(row.E_uncertainty == Approx(0.3));
  CHECK(row.E_dispersion == Approx(0.15 + 0.35 * std::sqrt(32.0 / 3)));
  c.E = 1e15, c.evidence = {{kFoam, 9.0}};
  pool_statistics(row, {c});
  CHECK(row.log10_E == Approx(7.0));
  CHECK(row.E_mean == Approx(15.0));
  CHECK(row.E_spread == 0.25);
}

TEST_CASE("material: expected guard outcomes") {
  const InventoryRow row = make_row("x", "", "", {"Rubber", "Foam"});
  SUBCASE("applies below the cap") {
    // Best expected: Foam 0.33, cap = max(0.5775, 0.53).
    const EvidenceRow e = guarded(row, {{kWood, 0.42}, {kRubber, 0.25}, {kFoam, 0.33}}, {});
    CHECK(e.guards[0].applied);
    CHECK(e.label == kFoam);
    CHECK(e.confidence == Approx(0.33));
  }
  SUBCASE("mode above the cap") {
    // Best expected: Foam 0.25, cap = max(0.4375, 0.45).
    const EvidenceRow e = guarded(row, {{kWood, 0.55}, {kRubber, 0.20}, {kFoam, 0.25}}, {});
    CHECK_FALSE(e.guards[0].applied);
    CHECK(e.label == kWood);
  }
  SUBCASE("the larger of factor and margin is the cap") {
    // Foam 0.20: max(0.35, 0.40); Foam 0.30: max(0.525, 0.50).
    const auto applies = [&](double wood, double foam) {
      const double rest = 0.5 * (1 - wood - foam);
      return guarded(row, {{kWood, wood}, {kFoam, foam}, {kStone, rest}, {kGlass, rest}}, {}).guards[0].applied;
    };
    CHECK(applies(0.38, 0.20));
    CHECK_FALSE(applies(0.42, 0.20));
    CHECK(applies(0.515, 0.30));
    CHECK_FALSE(applies(0.53, 0.30));
  }
  SUBCASE("expected probability below 0.18") {
    const EvidenceRow e =
        guarded(row, {{kWood, 0.21}, {kMetal, 0.21}, {kGlass, 0.21}, {kStone, 0.20}, {kRubber, 0.17}}, {});
    CHECK_FALSE(e.guards[0].applied);
  }
  SUBCASE("mode already expected") {
    CHECK_FALSE(guarded(row, {{kFoam, 1}}, {}).guards[0].applied);
  }
  SUBCASE("ties follow the expected order, not the posterior order") {
    const EvidenceRow e = guarded(row, {{kWood, 0.4}, {kFoam, 0.3}, {kRubber, 0.3}}, {});
    CHECK(e.guards[0].applied);
    CHECK(e.label == kRubber);
  }
  SUBCASE("nothing expected") {
    CHECK_FALSE(guarded(make_row("x", "", "", {}), {{kFoam, 1}}, {}).guards[0].applied);
  }
}

TEST_CASE("material: multi-view VLM guard outcomes") {
  // "blade": R(Metal) = 0.75. Mode Plastic 0.36 is expected, Metal 0.30 as well.
  const InventoryRow row = make_row("blade", "", "", {"Plastic", "Metal"});
  const LabelScores scores = {{kPlastic, 0.36}, {kMetal, 0.30}, {kWood, 0.34}};
  const VlmRecord good = make_vlm(0.60, kThreeViews, {{kMetal, 0.75}, {kWood, 0.25}});
  CHECK(guarded(row, scores, {good}).guards[1].applied);
  CHECK(guarded(row, scores, {good}).label == kMetal);
  const auto refused = [&](const VlmRecord& record) { return !guarded(row, scores, {record}).guards[1].applied; };
  CHECK(refused(make_vlm(0.59, kThreeViews, {{kMetal, 1}})));
  CHECK(refused(make_vlm(0.9, {"front", "front", "top", "left"}, {{kMetal, 1}})));
  CHECK(refused(make_vlm(0.9, kThreeViews, {{kMetal, 0.74}, {kWood, 0.26}})));
  CHECK(refused(make_vlm(0.9, kThreeViews, {{kWood, 1}})));     // not expected
  CHECK(refused(make_vlm(0.9, kThreeViews, {{kPlastic, 1}})));  // the label before
  VlmRecord abstained = good;
  abstained.abstain = true;
  CHECK(refused(abstained));
  // R(v) too small: no role word.
  CHECK_FALSE(guarded(make_row("x", "", "", {"Plastic", "Metal"}), scores, {good}).guards[1].applied);
  // "soft pad": R(Foam) = 0.75, R(Plasticine) = 0.35.
  const InventoryRow soft = make_row("soft pad", "", "", {"Foam", "Plasticine"});
  CHECK_FALSE(guarded(soft, {{kFoam, 0.5}, {kPlasticine, 0.45}}, {make_vlm(0.9, kThreeViews, {{kPlasticine, 1}})})
                  .guards[1]
                  .applied);
  // P(v) below 0.20; P(before) above 1.5 P(v); gap above 0.18.
  CHECK_FALSE(guarded(row, {{kPlastic, 0.28}, {kMetal, 0.19}, {kWood, 0.27}, {kFoam, 0.26}}, {good}).guards[1].applied);
  CHECK_FALSE(guarded(row, {{kPlastic, 0.37}, {kMetal, 0.24}, {kWood, 0.3}, {kFoam, 0.09}}, {good}).guards[1].applied);
  CHECK_FALSE(guarded(row, {{kPlastic, 0.595}, {kMetal, 0.405}}, {good}).guards[1].applied);
  // Two eligible records: the larger product wins; equal products: the first.
  const InventoryRow two = make_row("blade cushion", "", "", {"Plastic", "Metal", "Foam"});
  const LabelScores three = {{kPlastic, 0.36}, {kMetal, 0.32}, {kFoam, 0.32}};
  const VlmRecord metal = make_vlm(0.8, kThreeViews, {{kMetal, 1}}), foam = make_vlm(0.8, kThreeViews, {{kFoam, 1}});
  CHECK(guarded(two, three, {foam, metal}).label == kFoam);
  CHECK(guarded(two, three, {metal, foam}).label == kMetal);
  CHECK(guarded(two, three, {metal, make_vlm(0.9, kThreeViews, {{kFoam, 1}})}).label == kFoam);
}

TEST_CASE("material: elastic-solid guard outcomes") {
  const InventoryRow row = make_row("base", "load-bearing", "", {"Wood", "Foam"});
  const LabelScores scores = {{kFoam, 0.6}, {kMetal, 0.2}, {kWood, 0.2}};
  const VlmRecord strong = make_vlm(0.6, kThreeViews, {{kWood, 0.5}, {kStone, 0.2}, {kFoam, 0.3}});
  const EvidenceRow e = guarded(row, scores, {strong});
  CHECK(e.guards[2].applied);
  CHECK(e.label == kMetal);  // posterior tie with Wood: stored order
  const auto refused = [&](const InventoryRow& r, const VlmRecord& record) {
    return !guarded(r, scores, {record}).guards[2].applied;
  };
  CHECK(refused(make_row("base", "bearing", "", {"Wood", "Foam"}), strong));
  CHECK(refused(make_row("rigid base", "", "", {"Wood", "Foam"}), strong));  // the name does not count
  CHECK(refused(make_row("base", "rigidity", "", {"Wood"}), strong));        // whole words only
  CHECK(refused(make_row("base", "rigid", "", {"Wood", "Foam", "Rubber"}), strong));
  CHECK(refused(row, make_vlm(0.59, kThreeViews, {{kWood, 1}})));
  CHECK(refused(row, make_vlm(0.9, {"front", "back"}, {{kWood, 1}})));
  CHECK(refused(row, make_vlm(0.9, kThreeViews, {{kWood, 0.5}, {kStone, 0.19}, {kFoam, 0.31}})));
  CHECK(refused(row, make_vlm(0.9, kThreeViews, {{kWood, 0.49}, {kStone, 0.49}, {kFoam, 0.02}})));
  CHECK_FALSE(guarded(row, {{kWood, 1}}, {strong}).guards[2].applied);
  // No expected labels: the fraction is one.
  CHECK(guarded(make_row("base", "structural", "", {}), scores, {strong}).guards[2].applied);
}

TEST_CASE("material: whole-object record") {
  const WholeObject fallback = whole_object_record(std::nullopt);
  CHECK(fallback.branch == Branch::plasticine);
  CHECK(fallback.E == 5e5);
  CHECK(fallback.nu == 0.476);
  CHECK(fallback.rho == 5000);
  CHECK(whole_object_record(WholeObjectObservations{}).label == -1);
  WholeObjectObservations seen;
  CropRecord a, b;
  a.evidence = {{kRubber, 0.3}, {kFoam, 0.4}};
  b.evidence = {{kRubber, 0.3}};
  b.E = 1e9, b.E_uncertainty = 0.1, b.nu = 0.499;
  seen.crops = {a, b};
  const WholeObject rubber = whole_object_record(seen);
  CHECK(rubber.source == "crop");
  CHECK(rubber.label == kRubber);
  CHECK(rubber.branch == Branch::jelly);
  CHECK(rubber.E == 1e8);
  CHECK(rubber.nu == 0.485);
  CHECK(rubber.rho == 1100);
  seen.label = kFoam;
  CHECK(whole_object_record(seen).source == "authored");
  CHECK(whole_object_record(seen).rho == 100);
  seen.label = kMetal;
  seen.crops.clear();
  CHECK(whole_object_record(seen).E == Approx(std::sqrt(1e9 * 3e11)));
  CHECK(whole_object_record(seen).rho == 7800);
}

TEST_CASE("material: mask confidence is the mean over the views that show the row") {
  Inventory inventory;
  inventory.rows.resize(3);
  std::vector<ViewMasks> views(3);
  for (ViewMasks& view : views) view.rows.resize(3);
  views[0].rows[0] = {2, 1, {255, 0}, 0.8, "test"};
  views[1].rows[0] = {2, 1, {0, 255}, 0.6, "test"};
  views[2].rows[0] = {2, 1, {0, 0}, 0.1, "test"};    // empty: does not count
  views[0].rows[2] = {2, 1, {255, 255}, 0, "test"};  // observed, with no confidence: the floor of lifting
  views[1].rows[2] = {2, 1, {255, 255}, 0.35, "test"};
  const auto confidence = mask_confidences(inventory, views);
  CHECK(confidence[0] == Approx(0.7));
  CHECK(confidence[1] == 0);  // no mask: unavailable
  CHECK(confidence[2] == Approx(0.2));
  views[1].rows[2].pixels = {0, 0};
  CHECK(mask_confidences(inventory, views)[2] == Approx(0.05));  // not 0, which would read as 0.7
}

TEST_CASE("material: part confidence floors the mask at 0.2 and takes 0.7 for the sentinel") {
  EvidenceRow row;
  row.label = kFoam;
  row.confidence = 0.5;
  const auto gamma = [&](double mask) {
    row.mask_confidence = mask;
    pool_statistics(row, {});
    return row.part_confidence * (1 + row.E_dispersion) / 0.5;
  };
  CHECK(gamma(0.9) == Approx(0.9));
  CHECK(gamma(0.1) == Approx(0.2));
  CHECK(gamma(0) == Approx(0.7));
}

TEST_CASE("material: posteriors are distributions and rows do not influence each other") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<int> any(0, kLabelCount - 1);
  Inventory inventory;
  MaterialRecords records;
  for (int i = 0; i < 40; ++i) {
    InventoryRow row = make_row(i % 3 ? "soft blade" : "part", "", "", {kLabels[any(random)].name});
    row.part = "part" + std::to_string(i);
    inventory.rows.push_back(row);
    RowObservations seen;
    for (int j = 0; j < 3; ++j) {
      CropRecord crop;
      crop.E_mean = unit(random) - 1, crop.E_uncertainty = unit(random);
      for (int k = 0; k < 4; ++k) crop.evidence.emplace_back((any(random) / 4) * 4 + k, unit(random));
      crop.evidence.erase(std::remove_if(crop.evidence.begin(), crop.evidence.end(),
                                         [](const auto& e) { return e.first >= kLabelCount; }),
                          crop.evidence.end());
      seen.crops.push_back(crop);
    }
    records.rows.push_back(seen);
  }
  const std::vector<long> counts(40, 1);
  const std::vector<double> masks(40, 0.5);
  Evidence all, reversed;
  reason_about_materials(all, inventory, counts, masks, records);
  for (const EvidenceRow& row : all.rows) {
    double sum = 0, previous = 1;
    for (const auto& [label, p] : row.posterior) {
      CHECK(p <= previous);
      previous = p;
      sum += p;
    }
    CHECK(sum == Approx(1).epsilon(1e-12));
    CHECK(row.posterior.size() == 14);
    CHECK(std::pow(10, row.log10_E) >= kLabels[row.label].E_lo * (1 - 1e-12));
    CHECK(std::pow(10, row.log10_E) <= kLabels[row.label].E_hi * (1 + 1e-12));
  }
  std::reverse(inventory.rows.begin(), inventory.rows.end());
  std::reverse(records.rows.begin(), records.rows.end());
  reason_about_materials(reversed, inventory, counts, masks, records);
  for (int i = 0; i < 40; ++i) {
    CHECK(reversed.rows[39 - i].posterior == all.rows[i].posterior);
    CHECK(reversed.rows[39 - i].log10_E == all.rows[i].log10_E);
    CHECK(reversed.rows[39 - i].label == all.rows[i].label);
  }
}

TEST_CASE("material: a stated label is selected whatever was expected and observed") {
  const InventoryRow row = make_row("plate", "support", "", {"Ceramic"});
  RowObservations observed;
  observed.vlm = {make_vlm(0.95, kThreeViews, {{kGlass, 1.0}})};
  observed.stated.label = kSnow;
  observed.stated.rho = 150;
  const EvidenceRow evidence = row_evidence(row, observed, 3, 0.9, kWood);
  CHECK(evidence.label == kSnow);
  CHECK(evidence.confidence == 1);
  CHECK(evidence.probability(kSnow) == 1);
  CHECK_FALSE(evidence.fallback);
  CHECK(evidence.guards.back().name == "stated");
  CHECK(evidence.sources.size() >= 3);  // what was observed is still told
  CHECK(evidence.stated.rho == 150);
  // In the range of the stated label.
  CHECK(std::pow(10, evidence.log10_E) == Approx(kLabels[kSnow].E_default()));
}
