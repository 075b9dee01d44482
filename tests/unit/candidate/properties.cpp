// What holds for every scene's candidates: identities, domains, independence of the order of rows, the study switch.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "candidate/build.h"
#include "candidate/schedule.h"
#include "material/evidence.h"

using namespace physmas;
using namespace physmas::candidate;

namespace {

struct RandomScene {
  Inventory inventory;
  Evidence evidence;
  Plan plan;
  RunSpecification run;
  std::vector<long> gaussians;

  explicit RandomScene(unsigned seed) {
    static const std::vector<std::string> kNames = {"plate", "sponge", "icing", "candle", "hammer head", "thing"};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    inventory.objects = {{"cake", "cake", "", {}, {}}};
    MaterialRecords records;
    for (int i = 0; i < 6; ++i) {
      InventoryRow row;
      row.object = "cake";
      row.part = "part-" + std::to_string(i);
      row.name = kNames[random() % kNames.size()];
      for (int k = 0; k < 2; ++k) row.expected_labels.push_back(kLabels[random() % kLabelCount].name);
      inventory.rows.push_back(row);
      CropRecord crop;
      crop.E_mean = 3 * unit(random) - 2;
      crop.E_uncertainty = unit(random);
      crop.nu_mean = 3 * unit(random) - 2;
      crop.evidence = {{static_cast<int>(random() % kLabelCount), unit(random)}};
      RowObservations seen;
      seen.crops = {crop};
      records.rows.push_back(seen);
    }
    gaussians.assign(6, 10);
    material::reason_about_materials(evidence, inventory, gaussians, std::vector<double>(6, 0.8), records);
    run.screening.initial = 10;
    plan.resolved = true;
  }

  Round round() const { return build_initial(make_context(inventory, evidence, plan, run, gaussians), "plan.json"); }

  void reverse_rows() {
    std::reverse(inventory.rows.begin(), inventory.rows.end());
    std::reverse(evidence.rows.begin(), evidence.rows.end());
  }
};

}  // namespace

TEST_CASE("candidate: rows keep their identity, and values stay in the solver's domain") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const RandomScene scene(seed);
    std::set<std::string> ids;
    for (const Candidate& c : scene.round().candidates) {
      CHECK(ids.insert(c.id).second);
      REQUIRE(c.rows.size() == scene.inventory.rows.size());
      for (size_t r = 0; r < c.rows.size(); ++r) {
        CHECK(c.rows[r].key == scene.inventory.rows[r].key());
        CHECK(c.rows[r].row == static_cast<int>(r));
        const bool of_whole_object = c.id == "hard-support-bonded" || c.id == "solver-compatible";
        CHECK(c.rows[r].nu >= 0.05);
        CHECK(c.rows[r].nu <= (of_whole_object ? 0.485 : 0.45));
        CHECK(c.rows[r].rho >= 100);
        CHECK(c.rows[r].rho <= (of_whole_object ? 7800 : 3000));
        CHECK(c.rows[r].E > 0);
      }
    }
  }
}

TEST_CASE("candidate: the order of rows changes nothing but the order") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    RandomScene scene(seed);
    const Round forward = scene.round();
    scene.reverse_rows();
    const Round backward = scene.round();
    std::map<std::string, const Candidate*> found;
    for (const Candidate& c : backward.candidates) found[c.id] = &c;
    for (const Candidate& c : forward.candidates) {
      // The rows that these two choose break ties by row order.
      if (c.id == "uncertainty-sweep" || c.id == "alternative-material") continue;
      REQUIRE(found.count(c.id) == 1);
      const Candidate& other = *found[c.id];
      for (size_t r = 0; r < c.rows.size(); ++r) {
        const CandidateRow &a = c.rows[r], &b = other.rows[c.rows.size() - 1 - r];
        CHECK(a.key == b.key);
        CHECK((a.branch == b.branch && a.E == b.E && a.nu == b.nu && a.rho == b.rho && a.label == b.label));
      }
      CHECK(std::set<std::string>(c.retention.begin(), c.retention.end()) ==
            std::set<std::string>(other.retention.begin(), other.retention.end()));
      CHECK(c.timestep.dt == other.timestep.dt);
    }
  }
}

TEST_CASE("candidate: without structure projection no candidate has controls, and the round says so") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    RandomScene scene(seed);
    scene.run.ablation.structure_projection = false;
    const Round round = scene.round();
    REQUIRE_FALSE(round.omitted.empty());
    CHECK(round.omitted.front().why == "ablation.structure_projection is false");
    for (const Candidate& c : round.candidates) {
      CHECK(c.projection.empty());
      CHECK(c.retention.empty());
      CHECK(std::none_of(c.schedule.begin(), c.schedule.end(), [](const auto& op) { return !op.is_action(); }));
    }
  }
}

TEST_CASE("candidate: a twist is enforced where rows are too stiff for a bounded force, and let go as by a hand") {
  RandomScene scene(1);
  PlanAction twist;
  twist.type = ActionType::torque;
  twist.target = "cake";
  twist.direction = {0, 0, 1};
  twist.magnitude = 2;
  twist.start = 0.1, twist.end = 1.1;
  twist.slab = true;
  PlanAction press = twist;
  press.type = ActionType::top_press;
  press.direction = {0, 0, -1};
  scene.plan.actions = {twist, press};
  const auto operation = [&](double E, int action) {
    scene.gaussians.assign(6, 10);
    Configuration configuration;
    for (size_t r = 0; r < scene.inventory.rows.size(); ++r) {
      CandidateRow row;
      row.row = static_cast<int>(r);
      row.E = r == 3 ? E : 1e4, row.nu = 0.25, row.rho = 1000;
      configuration.rows.push_back(row);
    }
    const Context context = make_context(scene.inventory, scene.evidence, scene.plan, scene.run, scene.gaussians);
    std::vector<Omission> omitted;
    TimestepResult timestep;
    timestep.dt = 1e-4;
    return compile_schedule(context, configuration, timestep, "plan.json", omitted)[action];
  };
  // A slab of 0.2 reaches across 0.6 of the scene within a second as far as c^2 = G / rho = 0.12 / 0.002 = 60, which
  // is E = 1.5e5 here.
  CHECK_FALSE(operation(1.4e5, 0).enforced);
  CHECK(operation(1.6e5, 0).enforced);
  CHECK(operation(1.6e5, 0).release == 0.25);
  CHECK(operation(1.6e5, 1).release == 0.25);
  // Half the size: a quarter of the modulus.
  scene.run.placement.extent = 0.5;
  CHECK(operation(0.4e5, 0).enforced);
  CHECK_FALSE(operation(0.35e5, 0).enforced);
  scene.run.placement.extent = 1;
  scene.run.controls.blend_stiff = scene.run.controls.literal_release = true;
  CHECK_FALSE(operation(1e9, 0).enforced);
  CHECK(operation(1e9, 0).release == 0);
  CHECK(operation(1e9, 1).release == 0);
  scene.run.controls = {};
  // A part of the object is held by the others; the whole of it turns freely, and goes on turning.
  scene.plan.actions[0].slab = false;
  CHECK_FALSE(operation(1e9, 0).enforced);
  CHECK(operation(1e9, 0).release == 0);
  scene.plan.actions[0].target = "cake/part-2";
  CHECK(operation(1e9, 0).enforced);
  CHECK(operation(1e9, 0).release == 0.25);
}
