// The execution record of a result: every number in its field, whatever became of the run.
#include "bind/execution.h"

#include <doctest/doctest.h>

#include <limits>

#include "bind/rollout.h"
#include "bind/start.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A finished run of three frames in which no two numbers are the same.
mpm::Result result() {
  mpm::Result r;
  r.frames_done = 3;
  r.steps = 400;
  r.dt = 2e-4;
  r.max_speed = 1.5;
  r.history.smallest_dt = 1e-4;
  r.history.largest_dt = 3e-4;
  r.history.retries = 5;
  r.history.discarded_steps = 320;
  r.min_J = 0.7;
  r.max_J = 1.3;
  r.measured_energy = true;
  r.particles_outside = 11;
  r.particles_at_wall = 12;
  r.omitted = {{"energy of rows", "no row has a potential"}};
  r.threads = 2;
  r.seconds_particles = 0.1;
  r.seconds_grid = 0.2;
  r.seconds_sort = 0.3;
  r.seconds_frames = 0.4;
  r.seconds_total = 1;
  r.particle_steps_per_second = 4e6;
  r.particle_bytes = 1000;
  r.grid_bytes = 2000;
  for (int f = 0; f < 3; ++f) {
    mpm::Balance balance;
    balance.frame = f;
    balance.mass = 2.5;
    balance.momentum = {1.0 + f, 2.0 + f, 3.0 + f};
    balance.kinetic = 10 + f;
    balance.elastic = 20 + f;
    balance.gravity = 30 + f;
    balance.control_work = 3 * f;
    balance.budget.change = 0.1 * f;
    balance.budget.transfer = 0.2 * f;
    balance.budget.contact = 0.3 * f;
    balance.budget.plastic = 0.4 * f;
    balance.budget.viscous = 0.5 * f;
    balance.budget.projection = 0.6 * f;
    balance.budget.control = 0.7 * f;
    balance.budget.structure = 0.8 * f;
    balance.budget.largest_step_residual = 0.01 * f;
    r.balances.push_back(balance);
  }
  return r;
}

mpm::Problem problem() {
  mpm::Problem p;  // dx = 0.075
  p.domain.n = 40;
  p.domain.length = 3;
  p.particles.position.resize(17);
  return p;
}

ExecutionRecord record_of(const mpm::Result& result, const mpm::Options& options = {}, const char* rule = "cfl") {
  bind::BoundTiming timing;
  timing.timing.substeps = 133;
  timing.rule = rule;
  Candidate candidate;
  candidate.id = "stiff";
  candidate.rows.resize(2);
  candidate.rows[0].key = "cake/sponge", candidate.rows[0].row = 0, candidate.rows[0].E = 3e4;
  candidate.rows[1].key = "cake/plate", candidate.rows[1].row = 2, candidate.rows[1].E = 7e10;
  return bind::execution_record(candidate, problem(), timing, options, result);
}

// The soft row was the fastest; the stiff one allows 1.5e-5 s.
mpm::Result diverged_result(const char* reason) {
  mpm::Result r = result();
  r.status = mpm::Status::diverged;
  r.reason = reason;
  r.first_bad_step = 42;
  r.fault_row = 0;
  r.stiffest_row = 2;
  r.stiffest_limit = 1.5e-5;
  return r;
}

}  // namespace

TEST_CASE("bind: the record of a stable run") {
  const ExecutionRecord r = record_of(result());
  CHECK(r.candidate == "stiff");
  CHECK_FALSE(r.diverged);
  CHECK(r.error_tokens.empty());
  CHECK(r.reason.empty());
  CHECK(r.first_bad_step == -1);
  CHECK(r.max_speed == 1.5);
  CHECK(r.J_min == 0.7);
  CHECK(r.J_max == 1.3);
  CHECK(r.mass == 2.5);
  CHECK(r.momentum_start == Eigen::Vector3d(1, 2, 3));
  CHECK(r.momentum_end == Eigen::Vector3d(3, 4, 5));
  CHECK(r.kinetic == std::vector<double>{10, 11, 12});
  CHECK(r.elastic == std::vector<double>{20, 21, 22});
  CHECK(r.potential == std::vector<double>{30, 31, 32});
  CHECK(r.energy_measured == "frames");
  CHECK(r.energy_terms.empty());
  CHECK(r.largest_step_residual == 0);
  CHECK(r.particles_outside == 11);
  CHECK(r.step_rule == "cfl");
  CHECK(r.substeps_per_frame == 133);
  CHECK(r.steps == 400);
  CHECK(r.dt == 2e-4);
  CHECK(r.smallest_dt == 1e-4);
  CHECK(r.largest_dt == 3e-4);
  CHECK(r.retries == 5);
  CHECK(r.discarded_steps == 320);
  CHECK(r.frames == 3);
  CHECK(r.particles == 17);
  CHECK(r.grid == Json({{"n", 40}, {"length", 3.0}}));
  CHECK(r.precision == "float");
  CHECK(r.deformation == "elastic");
  REQUIRE(r.omitted.size() == 1);
  CHECK(r.omitted[0].what == "energy of rows");
  CHECK(r.omitted[0].why == "no row has a potential");
  CHECK(r.runtime.at("seconds") ==
        Json({{"total", 1.0}, {"particles", 0.1}, {"grid", 0.2}, {"sort", 0.3}, {"frames", 0.4}}));
  CHECK(r.runtime.at("threads") == 2);
  CHECK(r.runtime.at("particle_steps_per_second") == 4e6);
  CHECK(r.runtime.at("solver_particle_bytes") == 1000);
  CHECK(r.runtime.at("solver_grid_bytes") == 2000);
}

TEST_CASE("bind: what was measured, in which precision") {
  mpm::Options options;
  options.precision = mpm::Precision::full;
  options.track_total_F = true;
  options.measure_steps = true;
  mpm::Result steps = result();
  steps.measured_steps = true;
  const ExecutionRecord r = record_of(steps, options);
  CHECK(r.precision == "double");
  CHECK(r.deformation == "total");
  CHECK(r.energy_measured == "steps");
  CHECK(r.largest_step_residual == 0.02);
  const std::vector<std::pair<std::string, double>> terms = {{"change", 0.1},  {"transfer", 0.2}, {"contact", 0.3},
                                                             {"plastic", 0.4}, {"viscous", 0.5},  {"projection", 0.6},
                                                             {"control", 0.7}, {"structure", 0.8}};
  REQUIRE(r.energy_terms.size() == terms.size() + 1);
  for (size_t i = 0; i < terms.size(); ++i) {
    CHECK(r.energy_terms[i].first == terms[i].first);
    CHECK(r.energy_terms[i].second == std::vector<double>{0, terms[i].second, 2 * terms[i].second});
  }
  CHECK(r.energy_terms.back().first == "residual");
  CHECK(r.energy_terms.back().second[2] == steps.balances[2].budget.residual());

  options = {};
  options.measure_energy = false;
  mpm::Result off = result();
  off.measured_energy = false;
  CHECK(record_of(off, options).energy_measured == "off");
  CHECK(record_of(off, options).elastic.empty());
}

TEST_CASE("bind: the record of a diverged run says why, in finite numbers") {
  mpm::Result diverged = diverged_result("speed");
  diverged.max_speed = kInfinity;
  diverged.balances.back().kinetic = kInfinity;
  ExecutionRecord r = record_of(diverged);
  CHECK(r.diverged);
  CHECK(r.error_tokens == std::vector<std::string>{"speed"});
  CHECK(r.reason == "speed in substep 42");
  CHECK(r.first_bad_step == 42);
  CHECK(r.max_speed == 0);
  CHECK(r.energy_residual == 0);
  CHECK(r.energy_scale == 0);

  diverged.reason = "budget";
  mpm::Options options;
  options.max_steps = 1234;
  CHECK(record_of(diverged, options).reason == "more than 1234 substeps, which --max-steps allows");
}

TEST_CASE("bind: a divergence names the row, the step that it would have needed, and what to set") {
  mpm::Result r = diverged_result("energy");
  r.dt = 5e-5;
  const auto why = [&](const char* rule) { return *record_of(r, {}, rule).divergence; };
  Divergence d = why("paper");  // longer than the stiff row bears
  CHECK(d.cause == "step");
  CHECK(d.row == "cake/plate");
  CHECK(d.E == 7e10);
  CHECK(d.wave_speed == doctest::Approx(5000));
  CHECK(d.dx == 0.075);
  CHECK(d.dt == 5e-5);
  CHECK(d.needed_dt == doctest::Approx(0.7 * 1.5e-5));
  CHECK(d.frame == 3);
  CHECK(d.advice ==
        "the motion breaks down before frame 3 of 49: cake/plate (E 70 GPa) is too stiff for substeps of 5e-05 s, it "
        "needs 1e-05 s; try SET=\"time.rule=cfl\", which takes as many as that asks for, or give it a softer "
        "material");
  r.dt = 1.4e-5;  // short enough: the motion of the fastest row is to blame
  d = why("paper");
  CHECK(d.cause == "motion");
  CHECK(d.row == "cake/sponge");
  CHECK(d.advice ==
        "the motion breaks down before frame 3 of 49: cake/sponge (E 30 kPa) is moved faster than its material can "
        "follow; ask for a gentler or slower action, or try SET=\"time.rule=cfl\"");
  r.dt = 5e-5;
  CHECK(why("cfl").cause == "motion");
  CHECK(why("cfl").advice.find("time.rule") == std::string::npos);
  r.reason = "step";
  CHECK(why("paper").cause == "step");
  r.reason = "budget";
  CHECK(why("paper").cause == "budget");
  CHECK(why("paper").row == "cake/plate");
  CHECK(why("paper").advice.find("10000000 substeps that are allowed") != std::string::npos);
  CHECK_FALSE(record_of(result()).divergence);
}

TEST_CASE("bind: of two attempts the stable one stands, and the record names both") {
  const ExecutionRecord first = record_of(diverged_result("speed"), {}, "paper"), second = record_of(result());
  const ExecutionRecord good = bind::with_retry(first, 1000, second, 500);
  CHECK_FALSE(good.diverged);
  CHECK(good.step_rule == "cfl");
  CHECK_FALSE(good.divergence);
  REQUIRE(good.attempts.size() == 2);
  CHECK(good.attempts[0].rule == "paper");
  CHECK(good.attempts[0].diverged);
  CHECK(good.attempts[0].reason == "speed in substep 42");
  CHECK(good.attempts[0].frames == 3);
  CHECK(good.attempts[0].steps == 400);
  CHECK(good.attempts[0].allowed == 1000);
  CHECK_FALSE(good.attempts[1].diverged);
  CHECK(good.attempts[1].allowed == 500);

  const ExecutionRecord bad = bind::with_retry(first, 1000, record_of(diverged_result("budget")), 500);
  CHECK(bad.diverged);
  CHECK(bad.step_rule == "paper");
  CHECK(bad.error_tokens == std::vector<std::string>{"speed"});
  CHECK(bad.divergence->advice.find("500 substeps of time.retry_substeps") != std::string::npos);
  CHECK(bind::with_retry(first, 1000, record_of(diverged_result("nan")), 500).divergence->row == "cake/plate");

  TemporaryFolder folder;
  Provenance provenance;
  provenance.tool = "test";
  save_execution(folder / "e.json", bad, provenance);
  const ExecutionRecord loaded = load_execution(folder / "e.json");
  REQUIRE(loaded.divergence);
  CHECK(loaded.divergence->advice == bad.divergence->advice);
  CHECK(loaded.divergence->needed_dt == bad.divergence->needed_dt);
  REQUIRE(loaded.attempts.size() == 2);
  CHECK(loaded.attempts[1].reason == bad.attempts[1].reason);
}

TEST_CASE("bind: a rollout holds the Gaussians' places, velocities and the deformation asked for") {
  TemporaryFolder folder;
  mpm::State state;
  for (int i = 0; i < 3; ++i) {  // the last one is a filled particle
    state.x.push_back({1.0 + i, 2.0 + i, 3.0 + i});
    state.v.push_back({4.0 + i, 5.0 + i, 6.0 + i});
    mpm::Mat3d F, total;
    for (int k = 0; k < 3; ++k) {
      F[k] = {10.0 * k + i, 10.0 * k + i + 1, 10.0 * k + i + 2};
      total[k] = -F[k];
    }
    state.F.push_back(F);
    state.total_F.push_back(total);
  }
  Provenance provenance;
  provenance.tool = "test";
  for (const bool total : {false, true}) {
    mpm::Options options;
    options.track_total_F = total;
    CHECK(bind::deformation_name(options) == (total ? "total" : "elastic"));
    bind::RolloutRecorder recorder(folder / "r.h5", 2, options, provenance);
    recorder.append({0, 0, state});
    recorder.append({1, 0.5, state});
    recorder.commit();
    const RolloutReader reader(folder / "r.h5", 2);
    CHECK(reader.frame_count() == 2);
    CHECK(reader.time(1) == 0.5);
    const RolloutFrame frame = reader.frame(1);
    CHECK(frame.position == std::vector<float>{1, 2, 3, 2, 3, 4});
    CHECK(frame.velocity == std::vector<float>{4, 5, 6, 5, 6, 7});
    std::vector<float> F = {0, 1, 2, 10, 11, 12, 20, 21, 22, 1, 2, 3, 11, 12, 13, 21, 22, 23};
    if (total)
      for (float& f : F) f = -f;
    CHECK(frame.F == F);
  }
}

TEST_CASE("bind: Gaussians that begin under load are carried by the deformation since then") {
  TemporaryFolder folder;
  const mpm::Mat3d F0 = {{{1.1, 0.02, 0}, {0.02, 0.9, -0.03}, {0, -0.03, 1.05}}};
  const mpm::Mat3d since = {{{0.5, 0.25, 0}, {-1, 2, 0.125}, {0, 0, 4}}};
  Provenance provenance;
  provenance.tool = "test";
  for (const bool total : {false, true}) {
    CAPTURE(total);
    mpm::Options options;
    options.track_total_F = total;
    mpm::State state;
    state.x = state.v = {{1, 2, 3}};
    bind::RolloutRecorder recorder(folder / "r.h5", 1, options, provenance);
    recorder.start_from({F0});
    state.F = {F0};
    state.total_F = {mpm::identity<double>()};
    recorder.append({0, 0.0, state});
    state.F = {since * F0};
    state.total_F = {since};
    recorder.append({1, 0.1, state});
    recorder.commit();
    const RolloutReader reader(folder / "r.h5", 1);
    for (int k = 0; k < 9; ++k) {
      CHECK(reader.frame(0).F[k] == (k % 4 == 0 ? 1.0f : 0.0f));
      CHECK(reader.frame(1).F[k] == doctest::Approx(since[k / 3][k % 3]).epsilon(1e-6));
    }
  }
}

TEST_CASE("bind: the start is looked for where the run asks, and recorded by the rows' keys") {
  mpm::Problem p;
  p.domain.n = 16;
  p.domain.gravity = {0, 0, -9.8};
  p.materials = {{mpm::Branch::jelly, 1e5, 0.3, 1000}, {mpm::Branch::sand, 1e5, 0.3, 1000}};
  mpm::Collider floor;
  floor.mode = mpm::Collider::Mode::sticky;
  floor.center = {0, 0, 0.75};
  p.domain.colliders = {floor};
  for (int i = 0; i < 8; ++i) {
    p.particles.position.push_back({0.9 + 0.06 * (i & 1), 0.9 + 0.06 * (i >> 1 & 1), 0.78 + 0.06 * (i >> 2)});
    p.particles.volume.push_back(0.06 * 0.06 * 0.06);
    p.particles.row.push_back(0);
  }
  RunSpecification::Time time;
  CHECK_FALSE(bind::bind_start(time, {}, p));
  CHECK(p.particles.deformation_gradient.empty());
  time.start = RunSpecification::Time::Start::equilibrium;
  const std::optional<mpm::Equilibrium> found = bind::bind_start(time, {}, p);
  REQUIRE(found);
  CHECK(found->supported_parts == 1);
  REQUIRE(p.particles.deformation_gradient.size() == 8);
  CHECK(p.particles.deformation_gradient[0][2].z < 1);

  mpm::Equilibrium e;
  e.supported_parts = 1, e.free_parts = 2, e.supported_particles = 3, e.iterations = 4, e.corrections = 5;
  e.residual = 0.6, e.largest_strain = 0.7;
  e.limited = {0, 8};
  const StartRecord r = bind::start_record(e, {"pot/rim", "pot/soil"});
  CHECK(r.supported_parts == 1);
  CHECK(r.free_parts == 2);
  CHECK(r.supported_particles == 3);
  CHECK(r.iterations == 4);
  CHECK(r.corrections == 5);
  CHECK(r.residual == 0.6);
  CHECK(r.largest_strain == 0.7);
  CHECK(r.limited == std::vector<std::pair<std::string, long>>{{"pot/soil", 8}});
}
