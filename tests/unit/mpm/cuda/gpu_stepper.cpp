// The stepper of a GPU against the CPU's in double precision, on random input. Its kernels run in an emulator of blocks
// and threads; with PM_GPU=1 on the card of this machine, where the build has kernels for it (make test-gpu). PM_SCALE
// multiplies the number of particles (make test-emulator).
#include "mpm/cuda/gpu_stepper.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>
#include <limits>
#include <numeric>

#include "mpm/cpu/cpu_stepper.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

constexpr Vec3d kUp = {0, 0, 1};
constexpr int kSteps = 200;
constexpr double kStep = 2e-4;

bool on_a_card() {
  const char* const wanted = std::getenv("PM_GPU");
  return wanted && *wanted != '\0';
}

int scaled(int particles) {
  const char* const scale = std::getenv("PM_SCALE");
  return scale ? particles * std::max(1, std::atoi(scale)) : particles;
}

std::unique_ptr<Stepper> make_gpu(Precision precision, const StepperSetup& setup) {
  if (on_a_card()) return make_stepper({Device::Kind::cuda, 1}, precision, setup);
  if (precision == Precision::full) return std::make_unique<emulated_gpu::GpuStepper<double>>(1, setup);
  return std::make_unique<emulated_gpu::GpuStepper<float>>(1, setup);
}

// Particles of a row anywhere in a box, in any state.
void add_random(Problem& p, int row, int count, const Vec3d& low, const Vec3d& high, const Vec3d& velocity = {0, 0, 0},
                double strain = 0.05) {
  std::mt19937 random(7 + row);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Vec3d size = high - low;
  const double volume = size.x * size.y * size.z / count;
  for (int i = 0; i < count; ++i) {
    Vec3d x;
    for (int a = 0; a < 3; ++a) x[a] = low[a] + 0.5 * (uniform(random) + 1) * size[a];
    p.particles.position.push_back(x);
    p.particles.volume.push_back(volume * (1 + 0.3 * uniform(random)));
    p.particles.row.push_back(row);
    p.particles.velocity.push_back(velocity + 0.2 * Vec3d{uniform(random), uniform(random), uniform(random)});
    Mat3d F = identity<double>();
    for (int k = 0; k < 9; ++k) F[k / 3][k % 3] += strain * uniform(random);
    p.particles.deformation_gradient.push_back(F);
  }
}

State start_of(const Problem& p, const StepperSetup& setup) {
  State state;
  state.x = p.particles.position;
  state.v = p.particles.velocity;
  state.F = p.particles.deformation_gradient;
  state.C.assign(state.size(), diagonal(0.0, 0.0, 0.0));
  state.total_F = state.F;
  for (const int row : setup.row) state.strength.push_back(setup.parameters[row].yield);
  return state;
}

struct Run {
  State state;
  StepReport report;
};

Run advance(Stepper& stepper, const Problem& p, const ActionPlan& actions, int steps = kSteps, double dt = kStep,
            double energy_limit = 1e30) {
  const StepperSetup setup = setup_of(p, actions);
  Run run;
  run.state = start_of(p, setup);
  stepper.load(run.state);
  run.report = stepper.advance(
      steps, dt, [&](int step, std::vector<Control>& out) { return actions.controls(step * dt, dt, out); },
      energy_limit);
  stepper.store(run.state);
  return run;
}
Run by_gpu(const Problem& p, Precision precision, int steps = kSteps, double dt = kStep, double energy_limit = 1e30) {
  const ActionPlan actions(p.schedule.actions, p.particles);
  return advance(*make_gpu(precision, setup_of(p, actions)), p, actions, steps, dt, energy_limit);
}
Run by_cpu(const Problem& p, int steps = kSteps, double dt = kStep, double energy_limit = 1e30) {
  const ActionPlan actions(p.schedule.actions, p.particles);
  return advance(*make_cpu_stepper(1, Precision::full, setup_of(p, actions)), p, actions, steps, dt, energy_limit);
}

double relative(const Mat3d& a, const Mat3d& b) {
  return std::sqrt(squared_norm(a - b) / squared_norm(a));
}

struct Difference {
  double x = 0, F = 0, total_F = 0, v = 0, C = 0, strength = 0;  // cells, 1, 1, cells per substep, 1 per substep, 1
};
Difference difference(const Problem& p, const State& a, const State& b) {
  Difference d;
  for (size_t i = 0; i < a.size(); ++i) {
    d.x = std::max(d.x, norm(a.x[i] - b.x[i]) / p.domain.dx());
    d.F = std::max(d.F, relative(a.F[i], b.F[i]));
    d.total_F = std::max(d.total_F, relative(a.total_F[i], b.total_F[i]));
    d.v = std::max(d.v, norm(a.v[i] - b.v[i]) * kStep / p.domain.dx());
    d.C = std::max(d.C, std::sqrt(squared_norm(a.C[i] - b.C[i])) * kStep);
    d.strength = std::max(d.strength, std::fabs(a.strength[i] - b.strength[i]) / a.strength[i]);
  }
  return d;
}

// Whether both steppers end in the same state after 200 substeps, in both precisions. brakes: an action lets go of what
// is not faster than its field, which a particle that it has held is by a rounding or is not.
void check_same(const Problem& p, bool brakes = false) {
  const Run expected = by_cpu(p);
  REQUIRE(expected.report.fault == StepFault::none);
  for (const Precision precision : {Precision::single, Precision::full}) {
    const bool single = precision == Precision::single || brakes;
    CAPTURE(single);
    const Run run = by_gpu(p, precision);
    REQUIRE(run.report.fault == StepFault::none);
    CHECK(run.report.steps == kSteps);
    const Difference d = difference(p, expected.state, run.state);
    CHECK(d.x < (single ? 1e-4 : 1e-8));
    CHECK(d.F < (single ? 1e-5 : 1e-8));
    CHECK(d.total_F < (single ? 1e-5 : 1e-8));
    CHECK(d.v < (single ? 1e-6 : 1e-9));
    CHECK(d.C < (single ? 1e-5 : 1e-8));
    CHECK(d.strength < (single ? 1e-4 : 1e-8));
    CHECK(run.report.particles_clamped == expected.report.particles_clamped);
    CHECK(run.report.max_speed == doctest::Approx(expected.report.max_speed).epsilon(single ? 1e-4 : 1e-8));
    CHECK(run.report.control_work == doctest::Approx(expected.report.control_work).epsilon(single ? 1e-3 : 1e-5));
  }
}

Problem one_block(const Material& material, const Vec3d& velocity = {0.5, -0.3, -0.8}) {
  Problem p = scene(material, 32, {0, 0, -9.8});
  add_random(p, 0, scaled(250), {0.8, 0.9, 0.5}, {1.1, 1.15, 0.75}, velocity);
  return p;
}

bool same_bytes(const State& a, const State& b) {
  return std::memcmp(a.x.data(), b.x.data(), a.size() * sizeof(Vec3d)) == 0 &&
         std::memcmp(a.v.data(), b.v.data(), a.size() * sizeof(Vec3d)) == 0 &&
         std::memcmp(a.F.data(), b.F.data(), a.size() * sizeof(Mat3d)) == 0 &&
         std::memcmp(a.C.data(), b.C.data(), a.size() * sizeof(Mat3d)) == 0;
}

// Three rows of different laws that fall on a ball, one of them pressed.
Problem busy() {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  p.materials.push_back({Branch::sand, 1e5, 0.3, 1600});
  p.materials.push_back({Branch::plasticine, 1e5, 0.3, 1300});
  for (int row = 0; row < 3; ++row) {
    add_random(p, row, scaled(120), {0.7 + 0.2 * row, 0.8, 0.3}, {0.88 + 0.2 * row, 1.1, 0.5}, {0.3, 0, -1});
  }
  p.contact = {{0, 0, 1}, 0.3};
  Collider ball = floor_at(0);
  ball.type = Collider::Type::sphere;
  ball.center = {1, 1, 0.1};
  ball.radius = 0.25;
  p.domain.colliders.push_back(ball);
  p.schedule.actions.push_back(SlabMotion{{2}, {0, 0, -0.5}, kUp, 0.3, 0, 0.02, 0.01});
  return p;
}

}  // namespace

TEST_CASE("mpm gpu: every law ends where the CPU's double precision does") {
  for (int b = 0; b < kBranchCount; ++b) {
    CAPTURE(kBranchNames[b]);
    check_same(one_block({static_cast<Branch>(b), 1e5, 0.3, 1000}));
  }
}

TEST_CASE("mpm gpu: rows of all laws in one heap, each particle with its own elasticity") {
  Problem p = scene({Branch::jelly, 1e5, 0.3, 1000}, 32, {0, 0, -9.8});
  for (int b = 1; b < kBranchCount; ++b) p.materials.push_back({static_cast<Branch>(b), 5e4 * (1 + b), 0.3, 500.0 * b});
  for (int b = 0; b < kBranchCount; ++b) add_random(p, b, scaled(60), {0.8, 0.9, 0.5}, {1.1, 1.15, 0.75}, {0.5, 0, -1});
  SUBCASE("of its row") {
    check_same(p);
  }
  SUBCASE("of its own") {
    for (size_t i = 0; i < p.particles.size(); ++i) {
      Material m = p.materials[p.particles.row[i]];
      m.E *= 1 + 0.5 * std::sin(double(i)), m.rho *= 1 + 0.3 * std::cos(double(i)), m.nu = 0.2 + 0.001 * (i % 100);
      p.particles.material.push_back(m);
    }
    check_same(p);
  }
}

TEST_CASE("mpm gpu: stretches that no polynomial holds for, and turned inside out") {
  for (const Branch branch : {Branch::jelly, Branch::metal, Branch::sand, Branch::plasticine}) {
    CAPTURE(branch_name(branch));
    Problem p = scene({branch, 2e3, 0.3, 1000}, 32);
    add_random(p, 0, scaled(150), {0.8, 0.9, 0.5}, {1.1, 1.15, 0.75}, {0, 0, 0}, 0.7);
    const Run expected = by_cpu(p, 20, 1e-4);
    REQUIRE(expected.report.fault == StepFault::none);
    const Run run = by_gpu(p, Precision::full, 20, 1e-4);
    REQUIRE(run.report.fault == StepFault::none);
    const Difference d = difference(p, expected.state, run.state);
    CHECK(d.x < 1e-7);
    CHECK(d.F < 1e-6);
  }
}

TEST_CASE("mpm gpu: every action does what it does on the CPU, and the same work") {
  const double end = 0.03;
  const std::vector<Action> actions = {Translation{{0}, {0.3, 0, 0}, 0, end},
                                       SlabMotion{{0}, {0, 0, -0.3}, kUp, 0.2, 0, end, 0.01},
                                       SlabMotion{{0}, {0, 0, 0}, {0, 0, -1}, 0.2, 0, end},
                                       ScaleSlab{{0}, {1, 0, 0}, 1.3, 0.2, 1, 0, end},
                                       Impulse{{0}, {0.3, 0, 0}, 0.002, 8e-4, 2e-4},
                                       RadialSpread{{0}, kUp, 0.4, 2e-3, 0.1, 0, end},
                                       VerticalCompress{{0}, kUp, 0.8, 0.5, 0, end, 0.01},
                                       SideCompress{{0}, {1, 0, 0}, 0.8, 0.2, 0.5, 5e-4, 0.1, 0, end},
                                       DragFollow{{0}, {1}, {0.3, 0, 0}, 0.1, 2e-3, 0, end},
                                       Torque{{0}, kUp, 3, 1, 1.5, 2e-3, 0, end}};
  for (size_t a = 0; a < actions.size(); ++a) {
    CAPTURE(a);
    Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
    p.materials.push_back({Branch::metal, 1e5, 0.3, 1000});
    add_random(p, 0, scaled(100), {0.85, 0.85, 0.85}, {1.15, 1.15, 1.0}, {0, 0, 0}, 0.02);
    add_random(p, 1, scaled(60), {0.85, 0.85, 1.0}, {1.15, 1.15, 1.1}, {0, 0, 0}, 0.02);
    p.schedule.actions = {actions[a]};
    check_same(p, a == 1 || a == 6);
  }
}

TEST_CASE("mpm gpu: colliders of every shape and mode, and the walls") {
  for (const auto type : {Collider::Type::plane, Collider::Type::box, Collider::Type::sphere}) {
    for (const auto mode : {Collider::Mode::sticky, Collider::Mode::slip, Collider::Mode::separate}) {
      CAPTURE(static_cast<int>(type));
      CAPTURE(static_cast<int>(mode));
      Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000}, {0.4, 0, -2});
      p.particles.position.resize(scaled(120)), p.particles.volume.resize(scaled(120));
      p.particles.row.resize(scaled(120)), p.particles.velocity.resize(scaled(120));
      p.particles.deformation_gradient.resize(scaled(120));
      Collider c = floor_at(0.5, mode, 0.4);
      c.type = type;
      if (type == Collider::Type::box) c.center = {1, 1, 0.3}, c.half_size = {0.2, 0.3, 0.2};
      if (type == Collider::Type::sphere) c.center = {0.95, 1, 0.3}, c.radius = 0.25;
      p.domain.colliders = {c};
      check_same(p);
    }
  }
  // Into a corner, along walls.
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 24, {0, 0, -9.8});
  add_random(p, 0, scaled(150), {0.2, 0.2, 0.2}, {0.5, 0.5, 0.5}, {-2, -2, -3});
  check_same(p);
}

TEST_CASE("mpm gpu: bodies that meet, and rows that one body has") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  p.materials.push_back({Branch::metal, 1e5, 0.3, 3000});
  p.materials.push_back({Branch::sand, 1e5, 0.3, 500});
  add_random(p, 0, scaled(120), {0.8, 0.9, 0.5}, {1.0, 1.1, 0.7}, {1, 0, 0});
  add_random(p, 1, scaled(120), {1.0, 0.9, 0.5}, {1.2, 1.1, 0.7}, {-1, 0, 0});
  add_random(p, 2, scaled(120), {0.9, 0.9, 0.7}, {1.1, 1.1, 0.85}, {0, 0, -2});
  for (const double friction : {0.0, 0.4}) {
    p.contact = {{0, 1, 2}, friction};
    check_same(p);
  }
  p.contact = {{0, 1, 0}, 0.2};
  check_same(p);
}

TEST_CASE("mpm gpu: what flies far is sorted again and again, and comes to where the CPU's comes to") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  add_random(p, 0, scaled(150), {0.4, 0.4, 0.4}, {0.6, 0.6, 0.6}, {20, 15, 12});
  add_random(p, 0, scaled(60), {1.4, 0.4, 1.4}, {1.6, 0.6, 1.6}, {-20, 15, -18});
  const Run expected = by_cpu(p, 200, 2e-4);
  const Run run = by_gpu(p, Precision::single, 200, 2e-4);
  CHECK(run.report.sorts >= 10);
  const Difference d = difference(p, expected.state, run.state);
  CHECK(d.x < 1e-4);
  CHECK(d.F < 1e-5);
  CHECK(difference(p, expected.state, by_gpu(p, Precision::full).state).x < 1e-8);
}

TEST_CASE("mpm gpu: positions outside are put on the edge of the safe interior, and counted") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 16);
  add_random(p, 0, 40, {0.5, 0.5, 0.5}, {1, 1, 1});
  p.particles.position[3] = {-1, 1, 1};
  p.particles.position[5] = {1, 5, 1e6};
  const ActionPlan actions({}, p.particles);
  const StepperSetup setup = setup_of(p, actions);
  const auto stepper = make_gpu(Precision::single, setup);
  State state = start_of(p, setup);
  CHECK(stepper->load(state) == 2);
  stepper->store(state);
  const double dx = p.domain.dx();
  CHECK(norm(state.x[3] - Vec3d{2 * dx, 1, 1}) < 1e-6);
  CHECK(norm(state.x[5] - Vec3d{1, 14 * dx, 14 * dx}) < 1e-6);
  CHECK(norm(state.x[7] - p.particles.position[7]) < 1e-6);
  CHECK(state.v[7].x == doctest::Approx(p.particles.velocity[7].x));
}

TEST_CASE("mpm gpu: what rests at the edge of the grid is held there and counted as on the CPU") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000}, 16);
  p.domain.wall_cells = 2;
  add_random(p, 0, scaled(60), {0.25, 0.25, 0.25}, {0.5, 0.5, 0.5}, {0, 0, 0});
  // An enforced motion does not mind walls.
  p.schedule.actions.push_back(Translation{{0}, {-4, 0, 0}, 0, 1});
  const Run expected = by_cpu(p), run = by_gpu(p, Precision::single);
  CHECK(expected.report.particles_clamped > 0);
  CHECK(run.report.particles_clamped == expected.report.particles_clamped);
  CHECK(difference(p, expected.state, run.state).x < 1e-4);
}

TEST_CASE("mpm gpu: mass and momentum of a free body stay") {
  for (const Precision precision : {Precision::single, Precision::full}) {
    Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32);
    add_random(p, 0, scaled(250), {0.8, 0.8, 0.8}, {1.1, 1.1, 1.1}, {1, -0.5, 0.7});
    const auto momentum = [&](const State& s) {
      Vec3d sum = {0, 0, 0};
      for (size_t i = 0; i < s.size(); ++i) sum = sum + 1000 * p.particles.volume[i] * s.v[i];
      return sum;
    };
    const Run run = by_gpu(p, precision);
    State start;
    start.x = p.particles.position, start.v = p.particles.velocity;
    CHECK(norm(momentum(run.state) - momentum(start)) / norm(momentum(start)) <
          (precision == Precision::single ? 3e-6 : 1e-9));
  }
}

TEST_CASE("mpm gpu: two runs give the same bytes, whatever the order of blocks and threads") {
  using emulated_gpu::Order;
  for (const Precision precision : {Precision::single, Precision::full}) {
    const Problem p = busy();
    const Run first = by_gpu(p, precision);
    for (const Order order : {Order::ascending, Order::descending, Order::scattered}) {
      emulated_gpu::order_of_threads = order;
      const Run again = by_gpu(p, precision);
      CHECK(same_bytes(first.state, again.state));
      CHECK(first.report.control_work == again.report.control_work);
      CHECK(first.report.max_speed == again.report.max_speed);
    }
    emulated_gpu::order_of_threads = Order::ascending;
  }
}

TEST_CASE("mpm gpu: particles in another order end with the same bytes") {
  const Problem p = busy();
  std::vector<int> order(p.particles.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  Problem shuffled = p;
  for (size_t i = 0; i < order.size(); ++i) {
    shuffled.particles.position[i] = p.particles.position[order[i]];
    shuffled.particles.volume[i] = p.particles.volume[order[i]];
    shuffled.particles.row[i] = p.particles.row[order[i]];
    shuffled.particles.velocity[i] = p.particles.velocity[order[i]];
    shuffled.particles.deformation_gradient[i] = p.particles.deformation_gradient[order[i]];
  }
  const Run a = by_gpu(p, Precision::single), b = by_gpu(shuffled, Precision::single);
  State back = b.state;
  for (size_t i = 0; i < order.size(); ++i) {
    back.x[order[i]] = b.state.x[i], back.v[order[i]] = b.state.v[i];
    back.F[order[i]] = b.state.F[i], back.C[order[i]] = b.state.C[i];
  }
  CHECK(same_bytes(a.state, back));
  CHECK(a.report.control_work == b.report.control_work);
}

TEST_CASE("mpm gpu: an interval in parts is the interval, whether or not the state was looked at") {
  const Problem p = busy();
  const ActionPlan actions(p.schedule.actions, p.particles);
  const StepperSetup setup = setup_of(p, actions);
  const auto run = [&](bool look) {
    const auto stepper = make_gpu(Precision::single, setup);
    State state = start_of(p, setup);
    stepper->load(state);
    for (int part = 0; part < 4; ++part) {
      stepper->advance(
          25, kStep,
          [&](int step, std::vector<Control>& out) { return actions.controls((25 * part + step) * kStep, kStep, out); },
          1e30);
      State looked = state;
      if (look) stepper->store(looked);
    }
    stepper->store(state);
    return state;
  };
  CHECK(same_bytes(run(true), run(false)));
  const auto cpu = make_cpu_stepper(1, Precision::full, setup);
  State state = start_of(p, setup);
  cpu->load(state);
  for (int part = 0; part < 4; ++part) {
    cpu->advance(
        25, kStep,
        [&](int step, std::vector<Control>& out) { return actions.controls((25 * part + step) * kStep, kStep, out); },
        1e30);
  }
  cpu->store(state);
  CHECK(difference(p, state, run(false)).x < 1e-4);
}

TEST_CASE("mpm gpu: faults are those of the CPU, in the same substep") {
  SUBCASE("too fast") {
    Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000});
    p.domain.gravity = {0, 0, -2e6};
    const Run expected = by_cpu(p), run = by_gpu(p, Precision::single);
    CHECK(expected.report.fault == StepFault::speed);
    CHECK(run.report.fault == StepFault::speed);
    CHECK(run.report.steps == expected.report.steps);
  }
  SUBCASE("more energy than there can be") {
    Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000});
    const Run all = by_cpu(p, 100);
    double kinetic = 0;
    for (size_t i = 0; i < all.state.size(); ++i)
      kinetic += 500 * p.particles.volume[i] * dot(all.state.v[i], all.state.v[i]);
    const Run expected = by_cpu(p, 200, kStep, kinetic), run = by_gpu(p, Precision::single, 200, kStep, kinetic);
    CHECK(expected.report.fault == StepFault::energy);
    CHECK(run.report.fault == StepFault::energy);
    CHECK(std::abs(run.report.steps - expected.report.steps) <= 1);
  }
  SUBCASE("not finite, by one particle, which can be told from the others") {
    Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000});
    p.particles.velocity[17] = {std::nan(""), 0, 0};
    const Run expected = by_cpu(p), run = by_gpu(p, Precision::single);
    CHECK(expected.report.fault == StepFault::not_finite);
    CHECK(run.report.fault == StepFault::not_finite);
    CHECK(run.report.steps == expected.report.steps);
    CHECK(!std::isfinite(run.state.v[17].x));
  }
  SUBCASE("not finite, by a stress, whose particle can be told from the others, too") {
    Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000});
    p.particles.deformation_gradient[17][0].x = std::numeric_limits<double>::infinity();
    const Run expected = by_cpu(p), run = by_gpu(p, Precision::single);
    CHECK(expected.report.fault == StepFault::not_finite);
    CHECK(run.report.fault == StepFault::not_finite);
    CHECK(run.report.steps == expected.report.steps);
    CHECK(!std::isfinite(run.state.v[17].x));
  }
  SUBCASE("and it starts afresh afterwards") {
    Problem p = one_block({Branch::jelly, 5e4, 0.3, 1000});
    const ActionPlan actions({}, p.particles);
    const auto stepper = make_gpu(Precision::single, setup_of(p, actions));
    const Run clean = advance(*stepper, p, actions, 20);
    Problem fast = p;
    for (Vec3d& v : fast.particles.velocity) v = v + Vec3d{3000, 0, 0};
    CHECK(advance(*stepper, fast, actions, 20).report.fault == StepFault::speed);
    CHECK(same_bytes(advance(*stepper, p, actions, 20).state, clean.state));
  }
}

TEST_CASE("mpm gpu: no particle, and one") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 16);
  CHECK(by_gpu(p, Precision::single).report.steps == 0);
  add_random(p, 0, 1, {0.9, 0.9, 0.9}, {1, 1, 1}, {1, 0, 0});
  check_same(p);
}

TEST_CASE("mpm gpu: a whole run with projections, retentions and both step rules") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  p.materials.push_back({Branch::metal, 3e5, 0.3, 1500});
  add_random(p, 0, scaled(150), {0.8, 0.8, 0.45}, {1.1, 1.1, 0.7}, {0, 0, -2}, 0.01);
  add_random(p, 1, scaled(100), {0.8, 0.8, 0.7}, {1.1, 1.1, 0.8}, {0, 0, -2}, 0.01);
  p.domain.colliders.push_back(floor_at(0.4));
  p.schedule.actions.push_back(Impulse{{1}, {0.5, 0, 0}, 0.01, 8e-4, 2e-4});
  StructureProjection hold;
  hold.row = 1;
  SUBCASE("plain") {}
  SUBCASE("projected") {
    p.schedule.projections.push_back(hold);
  }
  SUBCASE("projected as a rigid body, and what is near retained") {
    hold.mode = StructureProjection::Mode::rigid;
    p.schedule.projections.push_back(hold);
    InterfaceRetention near;
    near.support = 1;
    near.rows = {0};
    p.schedule.retentions.push_back(near);
  }
  for (const StepRule rule : {StepRule::fixed, StepRule::cfl}) {
    const Timing timing = {5, 0.01, 50, rule};
    Options o = options(Precision::full, 1);
    o.track_total_F = true;
    const Outcome expected = simulate(p, timing, o);
    REQUIRE(expected.result.status == Status::stable);
    for (const Precision precision : {Precision::full, Precision::single}) {
      Options gpu = o;
      gpu.precision = precision;
      gpu.stepper = make_gpu;
      const Outcome out = simulate(p, timing, gpu);
      CHECK(out.result.status == Status::stable);
      CHECK(out.result.frames_done == 5);
      const Difference d = difference(p, expected.state, out.state);
      CHECK(d.x < (precision == Precision::full ? 1e-7 : 1e-4));
      CHECK(d.F < (precision == Precision::full ? 1e-7 : 1e-4));
      CHECK(out.result.balances.back().kinetic ==
            doctest::Approx(expected.result.balances.back().kinetic).epsilon(1e-4));
    }
  }
}

TEST_CASE("mpm gpu: a run that diverges says so with the same reason, and names the row") {
  Problem p = scene({Branch::jelly, 1e7, 0.3, 1000}, 32, {0, 0, -9.8});
  p.materials.push_back({Branch::jelly, 1e4, 0.3, 1000});
  add_random(p, 0, 150, {0.8, 0.8, 0.45}, {1.1, 1.1, 0.7}, {0, 0, 0}, 0.05);
  add_random(p, 1, 100, {0.3, 0.3, 0.7}, {0.6, 0.6, 0.8}, {0, 0, 0}, 0.01);
  const Timing timing = {4, 0.04, 80};
  Options o = options(Precision::single, 1);
  const Result expected = simulate(p, timing, o).result;
  o.stepper = make_gpu;
  const Result result = simulate(p, timing, o).result;
  CHECK(expected.status == Status::diverged);
  CHECK(result.status == Status::diverged);
  CHECK(result.reason == expected.reason);
  CHECK(result.fault_row == 0);
  CHECK(std::llabs(result.first_bad_step - expected.first_bad_step) <= 2);
}
