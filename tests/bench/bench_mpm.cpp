// Particle-steps per second of the solver, one tab-separated line per case.
//
// Each case is a cube of jittered particles, rotated against the grid, that falls and is squeezed or sheared by its
// initial velocity field, so that return maps are at work. Usage: bench_mpm [particles ...]
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "mpm/simulation.h"

using namespace physmas;
using namespace physmas::mpm;

namespace {

// About `count` particles, eight per cell, in a cube that is turned by half a radian about (1, 1, 1).
Problem make_problem(int count, const std::vector<Branch>& branches) {
  Problem p;
  p.domain.n = 100;
  p.domain.gravity = {0, 0, -9.8};
  const double spacing = p.domain.dx() / 2;
  const int side = static_cast<int>(std::lround(std::cbrt(static_cast<double>(count))));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-0.25, 0.25);
  const double c = std::cos(0.5), s = std::sin(0.5) / std::sqrt(3.0), d = (1 - c) / 3;
  const Mat3d R = {{{c + d, d - s, d + s}, {d + s, c + d, d - s}, {d - s, d + s, c + d}}};
  for (const Branch b : branches) {
    const double E = b == Branch::sand || b == Branch::snow ? 1e5 : 2e5;
    p.materials.push_back({b, E, 0.3, b == Branch::foam ? 200.0 : 1000.0});
  }
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      for (int k = 0; k < side; ++k) {
        const double h = 0.5 * (side - 1);
        const Vec3d q = {spacing * (i - h + jitter(random)), spacing * (j - h + jitter(random)),
                         spacing * (k - h + jitter(random))};
        p.particles.position.push_back(Vec3d{1, 1, 1} + R * q);
        p.particles.volume.push_back(spacing * spacing * spacing);
        p.particles.row.push_back(static_cast<int>((i * branches.size()) / side));
        // A squeeze strong enough to make every plastic branch yield.
        p.particles.velocity.push_back({-1.0 * q.x, 1.5 * q.y, -3.0 * q.z});
      }
    }
  }
  return p;
}

void report(const std::string& name, const Problem& problem, Precision precision, int threads, int steps) {
  Timing timing;
  timing.frames = 3;  // the first interval warms up caches and pages
  timing.substeps = steps;
  timing.frame_dt = steps * 2e-4;
  Options options;
  options.precision = precision;
  options.threads = threads;
  options.measure_energy = false;
  // Processor time from the first output frame on: what a busy machine does not distort with one thread.
  std::clock_t begin = 0, end = 0;
  const Result r =
      run(problem, timing, options, [&](const Frame& frame) { (frame.index == 0 ? begin : end) = std::clock(); });
  const double processor = static_cast<double>(end - begin) / CLOCKS_PER_SEC;
  const double count = static_cast<double>(problem.particles.size());
  std::printf("%s\t%s\t%d\t%.0f\t%lld\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%d\t%s\n", name.c_str(),
              precision == Precision::single ? "float" : "double", threads, count, r.steps,
              r.particle_steps_per_second / 1e6, 1e9 * processor / (count * static_cast<double>(r.steps)),
              1e6 * r.seconds_particles / static_cast<double>(r.steps),
              1e6 * r.seconds_grid / static_cast<double>(r.steps), 1e6 * r.seconds_sort / static_cast<double>(r.steps),
              1e6 * (r.seconds_particles + r.seconds_grid + r.seconds_sort) / static_cast<double>(r.steps), r.sorts,
              r.status == Status::stable ? "stable" : r.reason.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {2000, 10000, 200000};
  std::printf(
      "case\tprecision\tthreads\tparticles\tsteps\tmillion particle-steps/s\tprocessor ns/particle-step\tparticles "
      "us/step\tgrid us/step\t"
      "sort us/step\ttotal us/step\tsorts\tstatus\n");
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  std::vector<int> thread_counts = {1};
  if (cores > 1) thread_counts.push_back(cores);
  for (const int size : sizes) {
    const int steps = size > 50000 ? 60 : size > 5000 ? 300 : 1000;
    for (const int threads : thread_counts) {
      for (int b = 0; b < kBranchCount; ++b) {
        report(kBranchNames[b], make_problem(size, {static_cast<Branch>(b)}), Precision::single, threads, steps);
      }
      report("all six",
             make_problem(size,
                          {Branch::jelly, Branch::metal, Branch::sand, Branch::foam, Branch::snow, Branch::plasticine}),
             Precision::single, threads, steps);
      report("Jelly", make_problem(size, {Branch::jelly}), Precision::full, threads, steps);
    }
  }
  return 0;
}
