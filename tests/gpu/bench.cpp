// The speed of a substep on a GPU beside the CPU's in the same run, and what starting the GPU takes; a tab-separated
// line per case. Usage: bench [--emulate] [particles ...]; by default 20,000, 200,000 and 2,000,000.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "base/clock.h"
#include "bench/cube.h"
#include "mpm/cuda/gpu_stepper.h"
#include "mpm/stepper.h"

using namespace bench;

namespace {

struct GpuCase {
  BenchCase bench;
  bool pressed = false;  // an action is at work
};

StepperSetup setup_of(const Problem& p, const ActionPlan& actions) {
  StepperSetup setup;
  setup.domain = p.domain;
  for (const Material& m : p.materials) {
    setup.branches.push_back(m.branch);
    setup.parameters.push_back(derive_parameters(m, p.constants));
  }
  setup.row = p.particles.row;
  setup.volume = p.particles.volume;
  setup.control_group = actions.group_of();
  return setup;
}

State start_of(const Problem& p, const StepperSetup& setup) {
  State state;
  state.x = p.particles.position;
  state.v = p.particles.velocity;
  state.F.assign(state.size(), identity<double>());
  state.C.assign(state.size(), diagonal(0.0, 0.0, 0.0));
  for (const int row : setup.row) state.strength.push_back(setup.parameters[row].yield);
  return state;
}

// Seconds per substep, after some to warm up; and the sorts among them.
double measure(Stepper& stepper, const State& start, const ActionPlan& actions, int steps, int& sorts) {
  constexpr double kStep = 1e-4;
  const auto controls = [&](int step, std::vector<Control>& out) { return actions.controls(step * kStep, kStep, out); };
  stepper.load(start);
  stepper.advance(std::min(steps, 64), kStep, controls, 1e30);
  const Stopwatch watch;
  const StepReport report = stepper.advance(steps, kStep, controls, 1e30);
  sorts = report.sorts;
  if (report.fault != StepFault::none) std::printf("# diverged after %d substeps\n", report.steps);
  return watch.seconds() / report.steps;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  bool emulate = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--emulate") == 0) {
      emulate = true;
    } else {
      sizes.push_back(std::atoi(argv[i]));
    }
  }
  if (sizes.empty()) sizes = {20000, 200000, 2000000};
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const Stopwatch starting;
  if (!emulate) {
    const std::string absence = cuda_absence();
    if (!absence.empty()) {
      std::fprintf(stderr, "bench: %s\n", absence.c_str());
      return 2;
    }
  }
  std::printf("# looking for the GPU, its driver and kernels: %.2f s\n", starting.seconds());
  const std::vector<GpuCase> cases = {
      {{"Jelly", {Branch::jelly}}},
      {{"Metal", {Branch::metal}}},
      {{"Hencky elastic", {Branch::foam}, false}},
      {{"Sand, yielding", {Branch::sand}}},
      {{"all six, mixed, pressed",
        {Branch::jelly, Branch::metal, Branch::sand, Branch::foam, Branch::snow, Branch::plasticine}},
       true}};
  std::printf(
      "case\tparticles\tGPU us/substep\tGPU G particle-steps/s\tsorts of 1000\tGPU MB\tCPU threads\tCPU us/substep\t"
      "times faster\n");
  for (const int size : sizes) {
    for (const GpuCase& c : cases) {
      Problem p = make_problem(size, c.bench);
      if (size > 400000) {  // as many cells as hold that many particles
        const double finer = std::cbrt(static_cast<double>(size) / 200000);
        p.domain.n = static_cast<int>(std::lround(p.domain.n * finer));
        for (size_t i = 0; i < p.particles.size(); ++i) {
          p.particles.position[i] = Vec3d{1, 1, 1} + (1 / finer) * (p.particles.position[i] - Vec3d{1, 1, 1});
          p.particles.volume[i] /= finer * finer * finer;
        }
      }
      if (c.pressed) p.schedule.actions.push_back(SlabMotion{{0, 1, 2, 3, 4, 5}, {0, 0, -0.3}, {0, 0, 1}, 0.15, 0, 10});
      const ActionPlan actions(p.schedule.actions, p.particles);
      const StepperSetup setup = setup_of(p, actions);
      const State start = start_of(p, setup);
      const double count = static_cast<double>(p.particles.size());
      int sorts = 0, cpu_sorts = 0;
      double seconds = 0, megabytes = 0;
      {
        const std::unique_ptr<Stepper> gpu = emulate
                                                 ? std::make_unique<emulated_gpu::GpuStepper<float>>(cores, setup)
                                                 : make_stepper({Device::Kind::cuda, cores}, Precision::single, setup);
        seconds = measure(*gpu, start, actions, emulate ? 8 : 1000, sorts);
        const StepperUsage usage = gpu->usage();
        megabytes = static_cast<double>(usage.particle_bytes + usage.grid_bytes) / 1e6;
      }
      const auto cpu = make_stepper({Device::Kind::cpu, cores}, Precision::single, setup);
      const double cpu_seconds = measure(*cpu, start, actions,
                                         size > 1000000  ? 20
                                         : size > 100000 ? 60
                                                         : 300,
                                         cpu_sorts);
      std::printf("%s\t%.0f\t%.2f\t%.3f\t%d\t%.0f\t%d\t%.1f\t%.1f\n", c.bench.name.c_str(), count, 1e6 * seconds,
                  count / seconds / 1e9, sorts, megabytes, cpu->usage().threads, 1e6 * cpu_seconds,
                  cpu_seconds / seconds);
      std::fflush(stdout);
    }
  }
  return 0;
}
