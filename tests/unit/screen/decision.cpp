// The screen: features, gates, ranking, routing, audit. Golden numbers are worked out in the comments.
#include <doctest/doctest.h>

#include "screen/audit.h"
#include "screen/decide.h"
#include "screen/explain.h"
#include "screen/gates.h"
#include "screen/score.h"

using namespace physmas;
using namespace physmas::screen;
using doctest::Approx;

namespace {

constexpr int kFrames = 3;

CandidateRow row_of(const std::string& key, int index, Branch branch, double E, double rho, int label) {
  CandidateRow row;
  row.key = key;
  row.row = index;
  row.branch = branch;
  row.E = E, row.nu = 0.3, row.rho = rho;
  row.label = label;
  return row;
}

// One object: a plate (support) and a sponge (cohesive, Jelly).
struct Bench {
  Inventory inventory;
  Evidence evidence;
  Plan plan;
  double tau = 0.72;
  Executed executed;

  Bench() {
    inventory.objects = {{"cake", "Cake", "", {}, {}}};
    inventory.rows.resize(2);
    inventory.rows[0].object = inventory.rows[1].object = "cake";
    inventory.rows[0].part = "plate", inventory.rows[0].name = "Plate";
    inventory.rows[1].part = "sponge", inventory.rows[1].name = "Sponge";
    evidence.rows.resize(2);
    evidence.rows[0].part_confidence = 0.5;
    evidence.rows[1].part_confidence = 0.3;
    plan.resolved = true;
    executed.candidate.id = executed.candidate.transform = "posterior";
    executed.candidate.base_confidence = 0.4;
    executed.candidate.rows = {row_of("cake/plate", 0, Branch::metal, 1e9, 2500, kCeramic),
                               row_of("cake/sponge", 1, Branch::jelly, 1e5, 300, kFoam)};
    executed.render.video = "posterior.mp4";
    executed.render.file_size = 4096;
    executed.render.frames = {
        {0, true, 0, 0, 100, 100, 0.0}, {1, true, 0, 0, 9, 9, 0.0}, {2, true, 0, 0, 100, 100, 0.0}};
  }
  bool excuse_rotation = true;
  SceneRecords scene() const {
    SceneRecords records{inventory, evidence, plan, kFrames, tau, RunSpecification::Screening().weights, true, 0, {}};
    records.excuse_rotation = excuse_rotation;
    return records;
  }
  void last(int width, int height, double dark = 0) {
    executed.render.frames[2] = {2, true, 0, 0, width, height, dark};
  }
  ScreenedCandidate screened() const {
    ScreenedCandidate s;
    score_candidate(s, executed, scene());
    check_gates(s, executed, scene());
    return s;
  }
};

}  // namespace

TEST_CASE("screen: golden score") {
  const Bench bench;
  const ScreenedCandidate s = bench.screened();
  CHECK(s.video == Approx(0.32));
  CHECK(s.part_confidence == Approx(0.4));
  CHECK(s.diversity == 1);
  CHECK(s.role == Approx(0.85));  // Plate 1, Sponge 0.7
  CHECK(s.base == 0.4);
  CHECK(s.density == 1);
  CHECK(s.solver == 1);
  CHECK(s.penalty == 0);
  // 0.32 + 0.27*0.4 + 0.10 + 0.25*0.85 + 0.15*0.4 + 0.08 + 0.15 = 1.0305
  CHECK(s.score == Approx(1.0305));
  CHECK(s.valid);
}

TEST_CASE("screen: video feature tiers are exclusive and strict") {
  Bench bench;
  const auto video = [&] { return bench.screened().video; };
  bench.executed.render.file_size = 4095;
  CHECK(video() == Approx(-0.08));
  bench.executed.render.video.clear();
  CHECK(video() == Approx(-0.03));
  bench.executed.render.video = "v.mp4";
  bench.executed.render.file_size = 4096;
  bench.last(145, 100);
  CHECK(video() == Approx(0.32));
  bench.last(146, 100);
  CHECK(video() == Approx(0.22));
  bench.last(200, 100);
  CHECK(video() == Approx(0.22));
  bench.last(201, 100);
  CHECK(video() == Approx(0.07));
  bench.last(126, 44);
  CHECK(video() == Approx(0.10));
  bench.last(125, 44);
  CHECK(video() == Approx(0.32));
  bench.last(126, 45);
  CHECK(video() == Approx(0.32));
  bench.last(100, 100, 0.18);
  CHECK(video() == Approx(0.32));
  bench.last(100, 100, 0.19);
  CHECK(video() == Approx(0.24));
  // What the record measured apart, in one camera and uncut, wins over what the pictures show.
  bench.executed.render.endpoints = {{0, true, -5, 0, 95, 100, 0.0}, {2, true, 150, 0, 351, 100, 0.19}};
  CHECK(video() == Approx(-0.01));
  bench.executed.render.endpoints.clear();
  // No valid measurement: an empty frame, or a rollout that ended early.
  bench.executed.render.frames[2].present = false;
  CHECK(video() == Approx(0.20));
  bench.executed.render.frames.pop_back();
  CHECK(video() == Approx(0.20));
  CHECK(bench.screened().valid);
}

TEST_CASE("screen: what turned is not flattened, and its score is not lowered for it") {
  Bench bench;
  const auto gate = [&](const char* name) { return gate_passed(bench.screened(), name); };
  bench.last(220, 44);
  CHECK_FALSE(gate("flattening"));
  bench.last(300, 100);
  CHECK_FALSE(gate("spread"));
  // Toppled: in its own frame it is what it was.
  bench.last(260, 44);
  OwnFrame own;
  own.turned_back = own.put_back = {2, true, 0, 0, 100, 100, 0.0};
  bench.executed.render.own_frame = own;
  CHECK(gate("flattening"));
  CHECK(bench.screened().video == Approx(0.32));
  CHECK(bench.screened().video_terms.back().first.find("by turning") != std::string::npos);
  bench.last(300, 100);
  CHECK(gate("spread"));
  CHECK(bench.screened().video == Approx(0.32));
  // The milder tier of the score follows the own frame where that excuses.
  bench.executed.render.own_frame->turned_back = {2, true, 0, 0, 150, 100, 0.0};
  CHECK(gate("spread"));
  CHECK(bench.screened().video == Approx(0.22));
  // Both must hold: what melts while it comes near may keep its height in the image.
  bench.executed.render.own_frame->turned_back = {2, true, 0, 0, 201, 100, 0.0};
  CHECK_FALSE(gate("spread"));
  CHECK(bench.screened().video == Approx(0.07));
  bench.last(260, 44);
  CHECK_FALSE(gate("flattening"));
  bench.executed.render.own_frame = own;
  CHECK(gate("flattening"));
  bench.executed.render.own_frame->put_back = {2, true, 0, 0, 130, 40, 0.0};
  CHECK_FALSE(gate("flattening"));
  bench.last(300, 100);
  CHECK_FALSE(gate("spread"));
  bench.last(260, 44);
  // Nothing to see in the own frame excuses nothing.
  bench.executed.render.own_frame->put_back.present = false;
  CHECK_FALSE(gate("flattening"));
  // The paper's letter; both pairs are recorded all the same.
  bench.executed.render.own_frame = own;
  CHECK(gate("flattening"));
  bench.excuse_rotation = false;
  const ScreenedCandidate s = bench.screened();
  CHECK_FALSE(gate_passed(s, "flattening"));
  CHECK(s.video == Approx(0.10));
  const Json flattening = s.gates[4].measured;
  CHECK(flattening.at("height_ratio").get<double>() == Approx(0.44));
  CHECK(flattening.at("own_frame").at("height_ratio").get<double>() == Approx(1));
  CHECK(s.gates[4].limit.at("excuse_rotation") == false);
  CHECK(bench.screened().gates[3].measured.at("own_frame").at("area_growth").get<double>() == Approx(1));
}

TEST_CASE("screen: role, density and solver lookups") {
  Bench bench;
  CandidateRow& plate = bench.executed.candidate.rows[0];
  CandidateRow& sponge = bench.executed.candidate.rows[1];
  InventoryRow& part = bench.inventory.rows[1];
  const auto role = [&] { return 2 * bench.screened().role; };
  plate.E = 1e6;
  CHECK(role() == Approx(1.7));
  plate.E = 0.99e6;
  CHECK(role() == Approx(1.05));
  plate.E = 1e9, plate.branch = Branch::foam;
  CHECK(role() == Approx(1.05));
  plate.branch = Branch::metal;
  part.name = "Foam cushion";
  sponge.E = 1e8;
  CHECK(role() == Approx(2));
  sponge.E = 1.01e8;
  CHECK(role() == Approx(1.5));
  part.name = "x", part.structural_role = "support wheel";  // the name only
  CHECK(role() == Approx(1.7));

  const auto density = [&](double rho) { return sponge.rho = rho, 2 * bench.screened().density - 1; };
  CHECK(density(249) == Approx(0.35));
  CHECK(density(250) == Approx(1));
  CHECK(density(5000) == Approx(1));
  CHECK(density(5001) == Approx(0.55));

  part.name = "Dough", part.structural_role = "body";
  sponge.label = kPlasticine, sponge.branch = Branch::plasticine;
  CHECK(bench.screened().solver == 1);
  sponge.branch = Branch::jelly;
  CHECK(bench.screened().solver == 0.7);
  part.name = "Sponge";
  CHECK(bench.screened().solver == 1);
  sponge.branch = Branch::plasticine;
  CHECK(bench.screened().solver == 0.55);
  sponge.branch = Branch::metal;
  CHECK(bench.screened().solver == 0.7);
  sponge.branch = Branch::sand;  // no cohesive row is left
  CHECK(bench.screened().solver == 0.7);
  sponge.label = kCeramic;
  CHECK(bench.screened().diversity == 0.5);
}

TEST_CASE("screen: projection and bonding penalty") {
  Bench bench;
  bench.executed.candidate.projection = {{"cake/plate", 0.85}};
  bench.executed.candidate.retention = {"cake/plate"};
  CHECK(bench.screened().penalty == Approx(0.06));
  CHECK(bench.screened().score == Approx(0.9705));
  bench.executed.candidate.projection = {{"a", 1}, {"b", 1}, {"c", 1}, {"d", 1}, {"e", 1}};
  CHECK(bench.screened().penalty == Approx(0.12));
}

TEST_CASE("screen: each gate, with strict comparisons") {
  Bench bench;
  const auto fails = [&](const char* name) {
    const ScreenedCandidate s = bench.screened();
    CHECK(s.valid == gate_passed(s, name));  // no other gate fails
    return !gate_passed(s, name);
  };
  SUBCASE("plan") {
    bench.plan.resolved = false;
    CHECK(fails("plan"));
  }
  SUBCASE("exit") {
    bench.executed.execution.exit = 1;
    CHECK(fails("process"));
  }
  SUBCASE("signal") {
    bench.executed.execution.signal = 9;
    CHECK(fails("process"));
  }
  SUBCASE("token") {
    bench.executed.execution.error_tokens = {"nan"};
    CHECK(fails("numerical"));
  }
  SUBCASE("diverged") {
    bench.executed.execution.diverged = true;
    CHECK(fails("numerical"));
  }
  SUBCASE("spread") {
    bench.last(200, 100);
    CHECK_FALSE(fails("spread"));
    bench.last(201, 100);
    CHECK(fails("spread"));
  }
  SUBCASE("flattening") {
    bench.last(125, 44);
    CHECK_FALSE(fails("flattening"));
    bench.last(126, 45);
    CHECK_FALSE(fails("flattening"));
    bench.last(126, 44);
    CHECK(fails("flattening"));
  }
  SUBCASE("support") {
    bench.executed.candidate.rows[0].E = 1e7;
    CHECK_FALSE(fails("support"));
    bench.executed.candidate.rows[0].E = 0.999e7;
    CHECK(fails("support"));
    bench.executed.candidate.transform = "solver-compatible";
    CHECK_FALSE(fails("support"));
    bench.executed.candidate.transform = "solver-stability";  // a repair of it is not exempt
    CHECK(fails("support"));
    bench.inventory.rows[0].name = "x";
    bench.executed.candidate.rows[0].label = kPlastic;  // no support row is left
    CHECK_FALSE(fails("support"));
  }
}

TEST_CASE("screen: ranking, ties, admission and the repair base") {
  Bench bench;
  Executed a = bench.executed, b = a, c = a;
  a.candidate.id = "a", b.candidate.id = "b", c.candidate.id = "c";
  a.candidate.projection = {{"cake/plate", 1}};  // Q lower by 0.025
  ScreenRecord record = decide_round({a, b, c}, bench.scene(), 0, 3);
  CHECK(record.decision == "accept");
  CHECK(record.accepted == "b");  // equal to c, appears first
  CHECK(record.candidates[0].rank == 3);
  CHECK(record.candidates[1].rank == 1);
  CHECK(record.candidates[2].rank == 2);
  // The best score is not valid: the best admitted one wins.
  b.execution.error_tokens = {"nan"};
  record = decide_round({a, b, c}, bench.scene(), 0, 3);
  CHECK(record.accepted == "c");
  CHECK(record.candidates[1].rank == 1);
  // Nothing valid: the base is the best score of all, gates ignored.
  a.execution.exit = c.execution.exit = 1;
  record = decide_round({a, b, c}, bench.scene(), 1, 3);
  CHECK(record.decision == "repair");
  CHECK(record.repair_base == "b");
  CHECK(record.repair_routes == std::vector<std::string>{"solver-stability"});
  record = decide_round({a, b, c}, bench.scene(), 2, 3);
  CHECK(record.decision == "fail");
  CHECK(record.repair_base.empty());
  CHECK(explain(record).find("FAILED") != std::string::npos);
  // The threshold itself is admitted.
  bench.tau = decide_round({bench.executed}, bench.scene(), 0, 3).candidates[0].score;
  CHECK(decide_round({bench.executed}, bench.scene(), 0, 3).decision == "accept");
  bench.tau += 1e-9;
  record = decide_round({bench.executed}, bench.scene(), 0, 3);
  CHECK(record.decision == "repair");
  CHECK(record.repair_routes == std::vector<std::string>{"role-balanced"});
}

TEST_CASE("screen: routing of diagnostics to repairs") {
  Bench bench;
  const auto routes = [&] { return route_repairs(bench.screened(), bench.tau); };
  CHECK(routes().empty());
  bench.executed.candidate.rows[0].E = 1e6;
  CHECK(routes() == std::vector<std::string>{"support-stiffness", "rigid-support"});
  bench.last(126, 44);
  CHECK(routes() ==
        std::vector<std::string>{"support-stiffness", "rigid-support", "elastic-cohesion", "higher-cohesion"});
  bench.executed.execution.signal = 11;
  CHECK(routes().back() == "solver-stability");
  CHECK(routes().size() == 5);
  bench.tau = 99;  // a low score routes only when nothing else does
  CHECK(routes().size() == 5);
}

TEST_CASE("screen: audit") {
  Bench bench;
  ScreenRecord record = decide_round({bench.executed}, bench.scene(), 0, 3);
  audit_accepted(record, bench.executed, bench.scene(), "");
  CHECK(record.decision == "fail");
  CHECK(record.accepted.empty());
  CHECK_FALSE(record.audit_passed);
  CHECK(record.reason.find("video exists") != std::string::npos);
}

TEST_CASE("screen: unrelated rows do not change a candidate's gates") {
  Bench bench;
  const ScreenedCandidate before = bench.screened();
  std::swap(bench.executed.candidate.rows[0], bench.executed.candidate.rows[1]);
  const ScreenedCandidate after = bench.screened();
  CHECK(after.score == Approx(before.score).epsilon(1e-15));
  CHECK(after.valid == before.valid);
}

TEST_CASE("screen: what was achieved stands beside Q, and is a gate only where the run asks for it") {
  Bench bench;
  const double score = bench.screened().score;
  CHECK_FALSE(bench.screened().achieved);
  CHECK_FALSE(bench.screened().stillness);
  AchievedAction hold, twist;
  hold.share = 1, twist.share = 0.057;
  bench.executed.execution.achieved = {hold, twist};
  bench.executed.execution.stillness = Stillness{{"cake/plate"}, 0.02, 0.8};
  ScreenedCandidate s = bench.screened();
  CHECK(*s.achieved == 0.057);  // the one that was not done, not the mean
  CHECK(*s.stillness == 0.8);
  CHECK(s.score == score);
  CHECK(s.valid);
  CHECK(s.gates.size() == 6);
  bench.plan.still = true;  // standing still was asked for
  CHECK(*bench.screened().achieved == 0.8);
  bench.plan.still = false;

  const auto gated = [&](double achieved_min, std::optional<double> stillness_min) {
    SceneRecords scene = bench.scene();
    scene.achieved_min = achieved_min, scene.stillness_min = stillness_min;
    return decide_round({bench.executed}, scene, 0, 3);
  };
  CHECK(gated(0, 0).decision == "accept");
  CHECK(gated(0.05, 0.8).decision == "accept");
  ScreenRecord record = gated(0.5, 0);
  CHECK(record.decision == "repair");
  CHECK(record.repair_routes.empty());  // no repair makes an action stronger
  CHECK(record.reason.find("failed gates: achieved") != std::string::npos);
  CHECK_FALSE(gate_passed(record.candidates[0], "achieved"));
  const std::string text = explain(record);
  CHECK(text.find("achieved    FAILED  share 0.057; limit: share at least 0.5") != std::string::npos);
  CHECK(text.find("Q  achieved  still") != std::string::npos);
  CHECK(text.find("    0.06   0.80") != std::string::npos);
  record = gated(0, 0.81);
  CHECK(record.reason.find("failed gates: stillness") != std::string::npos);
  // Of a prompt that asks for no motion, half is not enough, but where the run says that it is.
  bench.executed.execution.stillness->share = 0.4;
  CHECK(gated(0, std::nullopt).decision == "accept");
  bench.plan.still = true;
  CHECK(gated(0, std::nullopt).reason.find("failed gates: stillness") != std::string::npos);
  CHECK(gated(0, 0).decision == "accept");
  bench.plan.still = false;
  // A motion that broke down is not rated by what it did until then.
  bench.executed.execution.diverged = true;
  CHECK_FALSE(bench.screened().achieved);
  CHECK_FALSE(bench.screened().stillness);
  bench.executed.execution.diverged = false;
  // Nothing was measured: nothing is refused.
  bench.executed.execution.achieved.clear();
  bench.executed.execution.stillness.reset();
  CHECK(gated(1, 1).decision == "accept");
  CHECK(explain(gated(1, 1)).find("achieved    pass    not measured") != std::string::npos);
}
