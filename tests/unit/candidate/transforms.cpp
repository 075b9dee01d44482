// Candidates: predicates, quantiles, every transform and repair, emission, schedule and step size.
#include "candidate/transforms.h"

#include <doctest/doctest.h>

#include <cmath>

#include "base/elasticity.h"
#include "candidate/build.h"
#include "candidate/compile_action.h"
#include "candidate/schedule.h"
#include "candidate/stiffness_weight.h"
#include "candidate/timestep.h"
#include "records/json.h"

using namespace physmas;
using namespace physmas::candidate;
using doctest::Approx;

namespace {

InventoryRow part(const std::string& object, const std::string& name, const std::string& role = "",
                  const std::string& group = "") {
  InventoryRow row;
  row.object = object;
  row.part = name.substr(0, name.find(' '));
  row.name = name;
  row.structural_role = role;
  row.physics_group = group;
  return row;
}

EvidenceRow evidence_of(const InventoryRow& row, int label, double log10_E, double nu, double gamma) {
  EvidenceRow e;
  e.key = row.key();
  e.label = label;
  e.gaussians = 1;
  e.log10_E = log10_E, e.E_dispersion = 0.5;
  e.nu = nu, e.nu_dispersion = 0.1;
  e.part_confidence = gamma;
  e.posterior = {{label, 0.9}, {label == kWood ? kMetal : kWood, 0.1}};
  return e;
}

// A plate (S), a sponge and an icing (C), a candle (neither) and a residual row, all of one cake that is hit.
struct Cake {
  Inventory inventory;
  Evidence evidence;
  Plan plan;
  RunSpecification run;
  std::vector<long> gaussians = {5, 5, 5, 5, 5};

  Cake() {
    inventory.objects = {{"cake", "Cake", "", {}, {}}};
    inventory.rows = {part("cake", "plate"), part("cake", "sponge"), part("cake", "icing layer"),
                      part("cake", "candle wick"), part("cake", "residual")};
    inventory.rows[4].residual = true;
    evidence.rows = {evidence_of(inventory.rows[0], kCeramic, 9.5, 0.25, 0.5),
                     evidence_of(inventory.rows[1], kFoam, 5.0, 0.30, 0.4),
                     evidence_of(inventory.rows[2], kPlasticine, 3.5, 0.37, 0.3),
                     evidence_of(inventory.rows[3], kPlastic, 7.0, 0.40, 0.6),
                     evidence_of(inventory.rows[4], kPlastic, std::log10(std::sqrt(5e15)), 0.375, 0.1)};
    evidence.rows[4].posterior = {{kPlastic, 1.0}, {kWood, 0.0}};
    PlanAction hit;
    hit.type = ActionType::impulse;
    hit.target = "cake";
    hit.direction = {0, 0, -1};
    hit.magnitude = 2;
    hit.end = 0.04;
    hit.impact = true;
    plan.actions = {hit};
    run.screening.initial = 10;
  }
  Context context() const { return make_context(inventory, evidence, plan, run, gaussians); }
  Configuration made(const std::string& name) const {
    std::string why;
    const auto configuration = transform(context(), name, why);
    REQUIRE_MESSAGE(configuration.has_value(), why);
    return *configuration;
  }
  bool emitted(const std::string& name) const {
    std::string why;
    return transform(context(), name, why).has_value();
  }
};

void check_row(const CandidateRow& row, Branch branch, double E, double nu, double rho) {
  CAPTURE(row.key);
  CHECK(row.branch == branch);
  CHECK(row.E == Approx(E).epsilon(1e-9));
  CHECK(row.nu == Approx(nu).epsilon(1e-12));
  CHECK(row.rho == Approx(rho).epsilon(1e-12));
}

Candidate base_of(const Configuration& configuration) {
  Candidate base;
  base.id = base.transform = "base";
  base.rows = configuration.rows;
  base.projection = configuration.projection;
  base.retention = configuration.retention;
  base.base_confidence = 0.38;
  return base;
}

}  // namespace

TEST_CASE("candidate: the stiffness weight is the first rule that matches") {
  CHECK(stiffness_weight(part("o", "plate stick"), true) == 1.6);
  CHECK(stiffness_weight(part("o", "candle with cream"), false) == 1.45);
  CHECK(stiffness_weight(part("o", "cream berry"), false) == 1.25);
  CHECK(stiffness_weight(part("o", "icing"), false) == 1.05);
  CHECK(stiffness_weight(part("o", "sponge"), false) == 1);
}

TEST_CASE("candidate: quantiles are monotone and stay inside the label's domain") {
  for (int label = 0; label < kLabelCount; ++label) {
    EvidenceRow row;
    row.label = label;
    row.log10_E = std::log10(kLabels[label].E_default()), row.E_dispersion = 1.5;
    row.nu = kLabels[label].nu_default(), row.nu_dispersion = 0.1;
    double E = 0, nu = 0;
    for (double kappa : {kQuantile15, kQuantile25, kMedian, kQuantile75, 1.04}) {
      CHECK(E_at(row, kappa) >= E);
      CHECK(nu_at(row, kappa) >= nu);
      E = E_at(row, kappa), nu = nu_at(row, kappa);
      CHECK(E >= kLabels[label].E_lo);
      CHECK(E <= kLabels[label].E_hi);
      CHECK(nu >= kLabels[label].nu_lo);
      CHECK(nu <= kLabels[label].nu_hi);
    }
  }
}

TEST_CASE("candidate: posterior, soft, stiff and the uncertainty sweep") {
  const Cake cake;
  const Configuration posterior = cake.made("posterior");
  REQUIRE(posterior.rows.size() == 5);
  check_row(posterior.rows[0], Branch::metal, std::pow(10, 9.5), 0.25, 2500);
  check_row(posterior.rows[1], Branch::foam, 1e5, 0.30, 300);  // rho 100 is lifted to 300
  check_row(posterior.rows[2], Branch::plasticine, std::pow(10, 3.5), 0.37, 2000);
  check_row(posterior.rows[4], Branch::metal, std::sqrt(5e15), 0.375, 1200);
  CHECK(posterior.projection.empty());
  CHECK(posterior.retention.empty());
  // Soft: 10^(e - 0.67 * 0.5) and nu + 0.067, the latter cut to the label's 0.35 for Ceramic.
  const Configuration soft = cake.made("soft");
  check_row(soft.rows[1], Branch::foam, std::pow(10, 4.665), 0.367, 300);
  check_row(soft.rows[0], Branch::metal, std::pow(10, 9.165), 0.317, 2500);
  check_row(soft.rows[3], Branch::metal, std::pow(10, 6.665), 0.45, 1200);
  const Configuration stiff = cake.made("stiff");
  check_row(stiff.rows[1], Branch::foam, std::pow(10, 5.335), 0.30, 300);
  // Sweep: the icing is the weakest semantic row; the residual row is weaker but does not count.
  const Configuration sweep = cake.made("uncertainty-sweep");
  check_row(sweep.rows[2], Branch::plasticine, 1e3, 0.437, 2000);  // 10^(3.5 - 0.52) is below the domain
  check_row(sweep.rows[1], Branch::foam, 1e5, 0.367, 300);
}

TEST_CASE("candidate: target-impact") {
  Cake cake;
  const Configuration impact = cake.made("target-impact");
  check_row(impact.rows[0], Branch::metal, 1e7, 0.25, 2500);
  check_row(impact.rows[1], Branch::foam, 7.5e4, 0.30, 300);
  check_row(impact.rows[2], Branch::plasticine, 2e4, 0.37, 450);
  check_row(impact.rows[3], Branch::metal, 1e7, 0.40, 1200);               // S = C = 0: posterior median
  check_row(impact.rows[4], Branch::metal, std::sqrt(5e15), 0.375, 1200);  // residual rows are never softened
  CHECK(impact.projection.empty());
  // A cohesive target whose branch is Metal becomes Foam.
  cake.inventory.rows[3].name = "candle core";
  check_row(cake.made("target-impact").rows[3], Branch::foam, 7.5e4, 0.40, 450);
  SUBCASE("not a target role") {
    cake.plan.actions[0].role = "source";
  }
  SUBCASE("no impact") {
    cake.plan.actions[0].impact = false;
  }
  SUBCASE("no cohesive semantic target") {
    cake.plan.actions[0].target = "cake/plate";
  }
  CHECK_FALSE(cake.emitted("target-impact"));
}

TEST_CASE("candidate: hard-support bonded and solver-compatible use the whole-object record") {
  Cake cake;
  const Configuration bonded = cake.made("hard-support-bonded");
  check_row(bonded.rows[0], Branch::metal, 1e7, 0.35, 2500);
  check_row(bonded.rows[1], Branch::plasticine, 5e5, 0.476, 5000);
  check_row(bonded.rows[2], Branch::plasticine, 1.05 * 5e5, 0.476, 5000);
  check_row(bonded.rows[3], Branch::plasticine, 1e7, 0.476, 5000);  // E^0 above omega E_g
  CHECK(bonded.projection == std::vector<std::pair<std::string, double>>{{"cake/plate", 0.85}});
  CHECK(bonded.retention == std::vector<std::string>{"cake/plate"});
  const Configuration compatible = cake.made("solver-compatible");
  check_row(compatible.rows[0], Branch::plasticine, 8e5, 0.476, 5000);
  check_row(compatible.rows[3], Branch::plasticine, 7.25e5, 0.476, 5000);
  check_row(compatible.rows[1], Branch::plasticine, 5e5, 0.476, 5000);
  CHECK(compatible.projection.empty());
  cake.evidence.whole_object = {"authored", kRubber, Branch::jelly, 1e6, 0.15, 1100};
  check_row(cake.made("solver-compatible").rows[1], Branch::jelly, 1e6, 0.2, 1100);
  cake.evidence.whole_object.branch = Branch::sand;
  check_row(cake.made("solver-compatible").rows[1], Branch::plasticine, 1e6, 0.2, 1100);
  SUBCASE("two objects never bond") {
    cake.inventory.objects.push_back({"hammer", "Hammer", "", {}, {}});
    cake.inventory.rows.push_back(part("hammer", "head"));
    cake.evidence.rows.push_back(evidence_of(cake.inventory.rows[5], kMetal, 10, 0.3, 0.5));
    cake.gaussians.push_back(0);
    CHECK(cake.made("hard-support-bonded").projection.size() == 2);
    CHECK(cake.made("hard-support-bonded").retention.empty());
  }
  SUBCASE("without a support row neither is emitted") {
    cake.inventory.rows[0].name = "food";
    CHECK_FALSE(cake.emitted("hard-support-bonded"));
    CHECK_FALSE(cake.emitted("solver-compatible"));
    CHECK_FALSE(cake.emitted("support-stiff"));
    CHECK_FALSE(cake.emitted("rigid-support"));
  }
}

TEST_CASE("candidate: support-stiff and rigid-support") {
  Cake cake;
  cake.evidence.rows[0].label = kFoam;  // the name makes it a support
  cake.evidence.rows[0].nu = 0.42;
  const Configuration stiff = cake.made("support-stiff");
  check_row(stiff.rows[0], Branch::metal, 1e7, 0.35, 1000);
  check_row(stiff.rows[1], Branch::foam, 1e5, 0.30, 300);
  CHECK(stiff.projection.empty());
  const Configuration rigid = cake.made("rigid-support");
  check_row(rigid.rows[0], Branch::foam, 1e7, 0.45, 300);  // branch and density are retained
  check_row(rigid.rows[1], Branch::foam, std::pow(10, 4.665), 0.367, 300);
  CHECK(rigid.projection == std::vector<std::pair<std::string, double>>{{"cake/plate", 1.0}});
}

TEST_CASE("candidate: alternative material") {
  Cake cake;
  CHECK_FALSE(cake.emitted("alternative-material"));                     // second labels below 0.12
  cake.evidence.rows[1].posterior = {{kFoam, 0.7}, {kFabric, 0.3}};      // 1e6 <= max(1e6, 1e7)
  cake.evidence.rows[2].posterior = {{kPlasticine, 0.6}, {kWood, 0.4}};  // 1.4e9 > max(3e4, 1e7)
  const Configuration alternative = cake.made("alternative-material");
  CHECK(alternative.rows[1].label == kFabric);
  check_row(alternative.rows[1], Branch::foam, 1e6, 0.325, 500);
  CHECK(alternative.rows[2].label == kPlasticine);
  // Ties: the first active row.
  cake.evidence.rows[2].posterior = {{kPlasticine, 0.7}, {kFoam, 0.3}};
  CHECK(cake.made("alternative-material").rows[2].label == kPlasticine);
  // A guard chose the second label: the posterior median stays, so the candidate equals the posterior.
  cake.evidence.rows[1].label = kFabric;
  CHECK(cake.made("alternative-material") == cake.made("posterior"));
}

TEST_CASE("candidate: order, budget, duplicates and omissions of round 0") {
  Cake cake;
  const auto ids = [](const Round& round) {
    std::vector<std::string> list;
    for (const Candidate& c : round.candidates) list.push_back(c.id);
    return list;
  };
  Round round = build_initial(cake.context(), "plan.json");
  CHECK(ids(round) == std::vector<std::string>{"posterior", "target-impact", "hard-support-bonded", "support-stiff",
                                               "solver-compatible", "rigid-support", "soft", "stiff",
                                               "uncertainty-sweep"});
  CHECK(round.omitted.back().what == "alternative-material");
  CHECK(round.candidates[3].order == 3);
  CHECK(round.candidates[3].base_confidence == Approx((0.5 + 0.4 + 0.3 + 0.6 + 0.1) / 5));
  cake.run.screening.initial = 6;
  round = build_initial(cake.context(), "plan.json");
  CHECK(ids(round).size() == 6);
  CHECK(ids(round).back() == "rigid-support");
  // A residual row without Gaussians is no active row.
  cake.gaussians[4] = 0;
  round = build_initial(cake.context(), "plan.json");
  CHECK(round.candidates[0].rows.size() == 4);
  CHECK(round.candidates[0].omitted.front().what == "row cake/residual");
  // The plate already is what support-stiff makes of it.
  cake.evidence.rows[0].label = kPlastic;
  cake.evidence.rows[0].log10_E = 7.0;
  round = build_initial(cake.context(), "plan.json");
  const std::vector<std::string> unique = ids(round);
  CHECK(std::find(unique.begin(), unique.end(), "support-stiff") == unique.end());
  CHECK(round.candidates[0].omitted.back().what == "support-stiff");
}

TEST_CASE("candidate: a scene without impact or support keeps the fixed order") {
  Cake cake;
  cake.plan.actions.clear();
  cake.inventory.rows[0].name = "food";
  const Round round = build_initial(cake.context(), "plan.json");
  REQUIRE(round.candidates.size() == 4);
  CHECK(round.candidates[0].id == "posterior");
  CHECK(round.candidates[1].id == "soft");
  CHECK(round.candidates[2].id == "stiff");
  CHECK(round.candidates[3].id == "uncertainty-sweep");
}

TEST_CASE("candidate: repairs of a base") {
  Cake cake;
  // A Ceramic plate below 1e7 Pa with low density, a Foam sponge that is projected, a candle that is neither.
  Candidate base = base_of(cake.made("posterior"));
  base.rows[0].E = 1e6, base.rows[0].nu = 0.4, base.rows[0].rho = 700;
  base.projection = {{"cake/sponge", 0.3}};
  const Context context = cake.context();
  Configuration r = repair(context, "support-stiffness", base);
  check_row(r.rows[0], Branch::metal, 1e7, 0.35, 1000);
  check_row(r.rows[1], Branch::foam, 1e5, 0.30, 300);
  CHECK(r.projection == base.projection);
  r = repair(context, "rigid-support", base);
  check_row(r.rows[0], Branch::metal, 1e7, 0.35, 1000);
  CHECK(r.projection == std::vector<std::pair<std::string, double>>{{"cake/plate", 1.0}, {"cake/sponge", 0.3}});
  r = repair(context, "elastic-cohesion", base);
  check_row(r.rows[0], Branch::metal, 1e7, 0.35, 1000);
  check_row(r.rows[1], Branch::jelly, 5e5, 0.30, 500);
  check_row(r.rows[2], Branch::jelly, 5e5, 0.37, 2000);
  check_row(r.rows[3], Branch::metal, 1e7, 0.40, 1200);  // neither
  r = repair(context, "higher-cohesion", base);
  check_row(r.rows[1], Branch::foam, 5e5, 0.30, 500);
  check_row(r.rows[2], Branch::plasticine, 5e5, 0.37, 2000);
  base.rows[1].nu = 0.476, base.rows[1].rho = 200;
  r = repair(context, "solver-stability", base);
  check_row(r.rows[1], Branch::foam, 1e5, 0.40, 300);
  check_row(r.rows[0], Branch::metal, 1e6, 0.40, 700);
  base.rows[2].branch = Branch::jelly;
  r = repair(context, "role-balanced", base);
  check_row(r.rows[0], Branch::metal, 1e7, 0.35, 1000);
  check_row(r.rows[1], Branch::jelly, 5e5, 0.42, 500);
  check_row(r.rows[2], Branch::jelly, std::pow(10, 3.5), 0.37, 2000);  // Jelly is left as it is
}

TEST_CASE("candidate: repair rounds keep the fixed order, skip what was seen, and inherit the base confidence") {
  Cake cake;
  std::vector<Candidate> seen = {base_of(cake.made("posterior"))};
  ScreenRecord screen;
  screen.decision = "repair";
  screen.repair_base = "base";
  screen.repair_routes = {"support-stiffness", "rigid-support", "elastic-cohesion", "higher-cohesion"};
  Round round = build_repairs(cake.context(), screen, seen, "plan.json");
  REQUIRE(round.candidates.size() == 3);
  CHECK(round.candidates[0].id == "base-support-stiffness");
  CHECK(round.candidates[2].id == "base-elastic-cohesion");
  CHECK(round.candidates[1].transform == "rigid-support");
  CHECK(round.candidates[1].parent == "base");
  CHECK(round.candidates[1].order == 2);
  CHECK(round.candidates[1].round == 1);
  CHECK(round.candidates[1].base_confidence == 0.38);
  CHECK(round.omitted[0].what == "base-higher-cohesion");
  seen.insert(seen.end(), round.candidates.begin(), round.candidates.end());
  screen.round = 1;
  round = build_repairs(cake.context(), screen, seen, "plan.json");
  REQUIRE(round.candidates.size() == 1);
  CHECK(round.candidates[0].id == "base-higher-cohesion");
  CHECK(round.candidates[0].order == 4);
  // Everything is within solver stability already: equal to the base, not emitted.
  seen[0].rows[3].nu = 0.3;
  screen.repair_routes = {"solver-stability"};
  round = build_repairs(cake.context(), screen, seen, "plan.json");
  CHECK(round.candidates.empty());
  CHECK(round.omitted[0].why == "its rows and controls equal those of base");
  screen.decision = "accept";
  CHECK(build_repairs(cake.context(), screen, seen, "plan.json").candidates.empty());
}

TEST_CASE("candidate: step-size rule") {
  const WholeObject whole;
  RunSpecification::Time time;
  // Independent script: c_ref = 56.655772 m/s; the fallback whole-object row alone moves at 27.20 m/s < 0.7 c_ref.
  TimestepResult t = step_size({}, whole, time, 0.02);
  CHECK(t.c_ref == Approx(56.6557723733));
  CHECK(t.c_max == Approx(wave_speed(5e5, 0.476, 5000)));
  CHECK(t.target == 2e-4);
  CHECK(t.substeps == 200);
  CHECK(t.dt == Approx(2e-4));
  CHECK(t.capped_by == "none");
  CandidateRow row;
  row.E = 1e7, row.nu = 0.35, row.rho = 2500;  // sqrt(2) c_ref: target = 0.7 * 2e-4 / sqrt(2), 404.06 -> 405
  t = step_size({row}, whole, time, 0.02);
  CHECK(t.target == Approx(1.4e-4 / std::sqrt(2.0)));
  CHECK(t.substeps == 405);
  CHECK(t.dt == 0.04 / 405);
  row.E = 3e11;
  t = step_size({row}, whole, time, 0.02);
  CHECK(t.substeps == 800);
  CHECK(t.dt == Approx(5e-5));
  CHECK(t.capped_by == "min_substep_dt");
  time.max_substeps = 300;
  CHECK(step_size({row}, whole, time, 0.02).substeps == 300);
  CHECK(step_size({row}, whole, time, 0.02).capped_by == "max_substeps");
  time.min_substep_dt = 1.5e-4;  // floor(0.04 / 1.5e-4) = 266
  CHECK(step_size({row}, whole, time, 0.02).substeps == 266);
  // Exactly at the threshold nothing changes; the whole-object row counts.
  row.E = 0.49 * 5e6;
  CHECK(step_size({row}, whole, time, 0.02).target == Approx(2e-4));
  WholeObject fast;
  fast.E = 1e9, fast.nu = 0.3, fast.rho = 1000;
  CHECK(step_size({row}, fast, time, 0.02).c_max == Approx(wave_speed(1e9, 0.3, 1000)));
}

TEST_CASE("candidate: schedule") {
  Cake cake;
  PlanAction press = cake.plan.actions[0];
  press.type = ActionType::top_press;
  press.source = "cake/icing";
  press.start = 0.1, press.end = 9;
  PlanAction late = press;
  late.type = ActionType::translation;
  late.start = 50, late.end = 60;
  cake.plan.actions = {cake.plan.actions[0], press, late};
  TimestepResult timestep;
  timestep.dt = 1e-4;
  std::vector<Omission> omitted;
  const auto ops = compile_schedule(cake.context(), cake.made("hard-support-bonded"), timestep, "plan.json", omitted);
  REQUIRE(ops.size() == 4);
  using Kind = ScheduleOperation::Kind;
  CHECK(ops[0].kind == Kind::impulse);
  CHECK(ops[0].rows == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(ops[0].velocity == Eigen::Vector3d(0, 0, -2));
  CHECK(ops[0].end == Approx(8e-4));  // four base substeps of 2e-4
  CHECK(ops[0].start_step == 0);
  CHECK(ops[0].end_step == 8);
  CHECK(ops[1].kind == Kind::top_press);
  CHECK(ops[1].rows == std::vector<int>{2});
  CHECK(ops[1].slab_fraction == 0.2);
  CHECK(ops[1].start_step == 1000);
  CHECK(ops[1].end == Approx(49 * 0.04));  // cut at the run's end
  CHECK(ops[1].end_step == 19600);
  CHECK(ops[2].kind == Kind::structure_projection);
  CHECK(ops[2].rows == std::vector<int>{0});
  CHECK(ops[2].eta == 0.85);
  CHECK(ops[3].kind == Kind::interface_retention);
  CHECK(ops[3].neighbours == std::vector<int>{1, 2, 3, 4});
  REQUIRE(omitted.size() == 1);
  CHECK(omitted[0].what == "action 2 of the plan");
  // An impulse shorter than a step acts for one step.
  cake.plan.actions = {cake.plan.actions[0]};
  timestep.dt = 0.01;
  cake.plan.actions[0].start = 0.011;
  const auto one = compile_schedule(cake.context(), {}, timestep, "plan.json", omitted);
  CHECK(one[0].end_step == one[0].start_step + 1);
}

TEST_CASE("candidate: every action compiles to its region, direction and numbers") {
  Cake cake;
  PlanAction action = cake.plan.actions[0];
  action.impact = false;
  action.magnitude = 0.5;
  action.direction = {1, 0, 0};
  action.start = 0.1, action.end = 0.9;
  const auto compiled = [&](ActionType type) {
    action.type = type;
    return compile_action(cake.context(), action, "plan.json", "/actions/0");
  };
  const std::vector<int> all = {0, 1, 2, 3, 4}, deformable = {1, 2, 3, 4}, support = {0};
  for (int i = 0; i < kActionCount; ++i) {
    const ScheduleOperation op = compiled(static_cast<ActionType>(i));
    CAPTURE(action_name(action.type));
    CHECK(static_cast<int>(op.kind) == i);
    CHECK(op.start == 0.1);
    CHECK(op.end == (action.type == ActionType::impulse ? Approx(0.1 + 8e-4) : Approx(0.9)));
    // Written and read again it is the same operation.
    Json json = to_json(op);
    CHECK(to_json(operation_from(json, "c.json", "/schedule/0")) == json);
    json.erase("start");
    CHECK_THROWS_AS(operation_from(json, "c.json", "/schedule/0"), Error);
  }
  CHECK(compiled(ActionType::radial_spread).rows == deformable);
  CHECK(compiled(ActionType::radial_spread).speed_limit == 0.5);
  CHECK(compiled(ActionType::vertical_compress).rows == deformable);
  CHECK(compiled(ActionType::vertical_compress).ratio == 0.5);
  CHECK(compiled(ActionType::side_compress).rows == all);
  CHECK(compiled(ActionType::side_compress).direction == Eigen::Vector3d(1, 0, 0));
  CHECK(compiled(ActionType::scale).slab_fraction == 0.2);
  const ScheduleOperation own_end = compiled(ActionType::drag_pair);
  CHECK(own_end.velocity == Eigen::Vector3d(0.5, 0, 0));
  CHECK(own_end.slab_fraction == 0.2);
  CHECK(own_end.neighbours.empty());
  action.source = "cake/plate";
  action.target = cake.inventory.rows[2].key();
  action.follow = Follow::interface;
  const ScheduleOperation pulled = compiled(ActionType::drag_pair);
  CHECK(pulled.rows == support);
  CHECK(pulled.slab_fraction == 1);
  CHECK(pulled.neighbours == std::vector<int>{2});
  CHECK(pulled.distance == 0.045);
  action.source = "";
  action.target = "cake";
  // A torque turns all of the target, or the slab at its upper end, whichever way it turns.
  action.direction = {0, 0, -1};
  action.slab = true;
  const ScheduleOperation torque = compiled(ActionType::torque);
  CHECK(torque.direction == Eigen::Vector3d(0, 0, 1));
  CHECK(torque.rate == -0.5);
  CHECK(torque.slab_fraction == 0.2);
  CHECK(compiled(ActionType::support_hold).slab_fraction == 0.2);
  action.slab = false;
  CHECK(compiled(ActionType::torque).slab_fraction == 1);
  // A hold takes the supports of an object, all of a row that is named, else the slab at the given end.
  CHECK(compiled(ActionType::support_hold).rows == support);
  CHECK(compiled(ActionType::support_hold).slab_fraction == 1);
  action.target = "cake/sponge";
  CHECK(compiled(ActionType::support_hold).rows == std::vector<int>{1});
  CHECK(compiled(ActionType::support_hold).slab_fraction == 1);
  cake.inventory.rows[0].object = "tray";
  action.target = "cake";
  CHECK(compiled(ActionType::support_hold).rows == deformable);
  CHECK(compiled(ActionType::support_hold).slab_fraction == 0.2);
}

TEST_CASE("candidate: the projection's mode is the run specification's") {
  Cake cake;
  TimestepResult timestep;
  timestep.dt = 1e-4;
  std::vector<Omission> omitted;
  for (const bool rigid : {false, true}) {
    cake.run.projection.rigid = rigid;
    for (const ScheduleOperation& op :
         compile_schedule(cake.context(), cake.made("hard-support-bonded"), timestep, "plan.json", omitted)) {
      if (op.kind != ScheduleOperation::Kind::structure_projection) continue;
      CHECK(op.rigid == rigid);
      CHECK(to_json(op)["mode"] == (rigid ? "rigid" : "literal"));
    }
  }
}

TEST_CASE("candidate: empty intervals, impossible ratios and rows without Gaussians are refused") {
  for (ActionType type :
       {ActionType::vertical_compress, ActionType::side_compress, ActionType::scale, ActionType::radial_spread}) {
    Cake cake;
    cake.plan.actions[0].type = type;
    cake.plan.actions[0].magnitude = 0;
    try {
      build_initial(cake.context(), "plan.json");
      FAIL("accepted");
    } catch (const Error& e) {
      CHECK(e.code() == ExitCode::invalid_input);
      CHECK(std::string(e.what()).find("/actions/0/magnitude") != std::string::npos);
    }
  }
  Cake cake;
  cake.plan.actions[0].end = 0;
  CHECK_THROWS_AS(build_initial(cake.context(), "plan.json"), Error);
  cake.plan.actions[0].end = 1;
  cake.plan.actions[0].target = "cake/residual";
  cake.gaussians[4] = 0;
  CHECK_THROWS_AS(build_initial(cake.context(), "plan.json"), Error);
}

TEST_CASE("candidate: every candidate holds every active row with its identity") {
  const Cake cake;
  for (const Candidate& c : build_initial(cake.context(), "plan.json").candidates) {
    REQUIRE(c.rows.size() == 5);
    for (int i = 0; i < 5; ++i) {
      CHECK(c.rows[i].row == i);
      CHECK(c.rows[i].key == cake.inventory.rows[i].key());
      CHECK(c.rows[i].E > 0);
      CHECK(c.rows[i].nu < 0.5);
    }
    CHECK(c.schedule.front().velocity == Eigen::Vector3d(0, 0, -2));
  }
}

TEST_CASE("candidate: a material field gives rows its median density, and particles take part in the step size") {
  Cake cake;
  State state;
  state.row_keys = cake.inventory.row_keys();
  state.row = {1, 1, 2};
  state.field.E = {1e5f, 1e7f, 9e6f};
  state.field.nu = {0.3f, 0.3f, 0.3f};
  state.field.rho = {400, 400, 400};
  const auto posterior = [&] {
    const Context context = make_context(cake.inventory, cake.evidence, cake.plan, cake.run, cake.gaussians, &state);
    return build_initial(context, "plan.json").candidates.front();
  };
  const Candidate without = posterior();
  CHECK_FALSE(without.rows[1].field);
  EvidenceRow::Field field;
  field.particles = field.sampled = 2;
  field.E.median = 1e5, field.nu.median = 0.3, field.rho.median = 400;
  cake.evidence.rows[1].field = field;
  const Candidate with = posterior();
  REQUIRE(with.id == "posterior");
  CHECK(with.rows[1].rho == 400);
  REQUIRE(with.rows[1].field);
  CHECK(with.rows[1].field->numbers.E == 1e5);
  CHECK(with.rows[1].field->label == kFoam);
  CHECK_FALSE(with.rows[0].field);
  // Without the stiff rows the fastest particle decides: 1e7 Pa at 400 kg/m^3; that of a row without a field does not.
  const WholeObject soft = {"fallback", -1, Branch::plasticine, 1, 0.3, 1000};
  const std::vector<CandidateRow> sponge = {with.rows[1]};
  CHECK(step_size(sponge, soft, {}, 0.02, &state).c_max == Approx(wave_speed(1e7, 0.3, 400)));
  CHECK(step_size(sponge, soft, {}, 0.02).c_max == Approx(wave_speed(1e5, 0.3, 400)));
}

TEST_CASE("candidate: what is stated of a row holds in every candidate and repair, as it stands") {
  Cake cake;
  // Beyond the ranges of Foam and of ordinary rows; of the plate a number alone.
  cake.evidence.rows[1].stated = {kFoam, 3e8, 0.47, 4500.0};
  cake.evidence.rows[0].stated.E = 12345;
  const auto check = [](const std::vector<Candidate>& candidates) {
    REQUIRE(!candidates.empty());
    for (const Candidate& c : candidates) {
      CAPTURE(c.id);
      check_row(c.rows[1], Branch::foam, 3e8, 0.47, 4500);
      CHECK(c.rows[1].label == kFoam);
      CHECK(c.rows[0].E == 12345);
    }
  };
  std::vector<Candidate> seen = build_initial(cake.context(), "plan.json").candidates;
  CHECK(seen.size() > 4);
  check(seen);
  ScreenRecord screen;
  screen.decision = "repair";
  screen.repair_base = "posterior";
  screen.repair_routes = {"support-stiffness", "rigid-support", "elastic-cohesion", "higher-cohesion"};
  check(build_repairs(cake.context(), screen, seen, "plan.json").candidates);
}
