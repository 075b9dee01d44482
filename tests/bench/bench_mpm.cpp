// The solver's speed next to what the machine can do, one tab-separated line per case.
//
// Usage: bench_mpm [particles ...]
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "bench/cube.h"
#include "mpm/math/lanes.h"

using namespace physmas;
using namespace physmas::mpm;
using namespace bench;

namespace {

// ---- What the machine can do.

// Floating-point operations per second of one thread that does nothing but fused multiply-adds in registers.
template <class T>
double measure_fma() {
  using V = Lanes<T>;
  constexpr int kChains = 24, kRounds = 1 << 21;  // enough chains to hide the latency
  V a[kChains];
  for (int i = 0; i < kChains; ++i) a[i] = V(T(i));
  V factor(T(0.999)), term(T(0.001));
  const Stopwatch watch;
  for (int round = 0; round < kRounds; ++round) {
#pragma GCC unroll 24
    for (int i = 0; i < kChains; ++i) a[i] = a[i] * factor + term;
  }
  const double seconds = watch.seconds();
  V sum(T(0));
  for (const V& x : a) sum += x;
  volatile T keep = stdx::reduce(sum);
  (void)keep;
  return 2.0 * kLanes<T> * kChains * kRounds / seconds;
}

// Bytes per second that one thread reads from memory and writes to it.
double measure_memory() {
  std::vector<float> a(1 << 25, 1.0f), b(1 << 25, 2.0f);
  double best = 0;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const Stopwatch watch;
    for (size_t i = 0; i < a.size(); ++i) a[i] = 0.5f * b[i] + a[i];
    best = std::max(best, 3.0 * sizeof(float) * static_cast<double>(a.size()) / watch.seconds());
  }
  return best;
}

// The same work on every core at once.
template <class Measure>
double on_all_cores(int cores, const Measure& measure) {
  std::vector<double> rate(cores);
  std::vector<std::thread> threads;
  for (int i = 0; i < cores; ++i) threads.emplace_back([&, i] { rate[i] = measure(); });
  double sum = 0;
  for (int i = 0; i < cores; ++i) {
    threads[i].join();
    sum += rate[i];
  }
  return sum;
}

// ---- Cases.

void report(const BenchCase& bench, int count, Precision precision, int threads, int steps, double fma) {
  const Problem problem = make_problem(count, bench);
  Timing timing;
  timing.frames = 3;  // the first interval warms up caches and pages
  timing.substeps = steps;
  timing.frame_dt = steps * 2e-4;
  Options options;
  options.precision = precision;
  options.device.threads = threads;
  options.measure_energy = false;
  // Processor time from the first output frame on: what a busy machine distorts least with one thread.
  std::clock_t begin = 0, end = 0;
  const Result r =
      run(problem, timing, options, [&](const Frame& frame) { (frame.index == 0 ? begin : end) = std::clock(); });
  const double processor = static_cast<double>(end - begin) / CLOCKS_PER_SEC;
  const double particles = static_cast<double>(problem.particles.size()), done = static_cast<double>(r.steps);
  const double micro = 1e6 / done;
  std::printf("%s\t%s\t%d\t%.0f\t%lld\t%.1f\t%.2f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%d\t%.0f\t%s\n", bench.name.c_str(),
              precision == Precision::single ? "float" : "double", threads, particles, r.steps,
              r.particle_steps_per_second / 1e6, r.particle_steps_per_second * 1000 / fma,
              1e9 * processor / (particles * done), micro * r.seconds_particles, micro * r.seconds_grid,
              micro * r.seconds_sort, micro * (r.seconds_particles + r.seconds_grid + r.seconds_sort), r.sorts,
              static_cast<double>(r.particle_bytes) / particles,
              r.status == Status::stable ? "stable" : r.reason.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {2000, 10000, 200000};
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<int> thread_counts = {1};
  if (cores > 1) thread_counts.push_back(cores);
  double fma[2][2];  // [double][all cores]
  for (const bool all : {false, true}) {
    const int used = all ? cores : 1;
    fma[0][all] = on_all_cores(used, measure_fma<float>);
    fma[1][all] = on_all_cores(used, measure_fma<double>);
    std::printf("# %d thread%s: fused multiply-adds %.0f Gflop/s float, %.0f double; memory %.1f GB/s\n", used,
                used == 1 ? "" : "s", fma[0][all] / 1e9, fma[1][all] / 1e9, on_all_cores(used, measure_memory) / 1e9);
  }
  std::printf(
      "case\tprecision\tthreads\tparticles\tsteps\tmillion particle-steps/s\tshare of FMA at 1000 flop\tprocessor "
      "ns/particle-step\tparticles us/step\tgrid us/step\tsort us/step\ttotal "
      "us/step\tsorts\tbytes/particle\tstatus\n");
  std::vector<BenchCase> cases;
  for (int b = 0; b < kBranchCount; ++b) cases.push_back({kBranchNames[b], {static_cast<Branch>(b)}});
  cases.push_back({"Hencky elastic", {Branch::foam}, false});
  cases.push_back({"Jelly, aligned", {Branch::jelly}, true, false});
  cases.push_back({"Jelly, a field", {Branch::jelly}, true, true, true});
  cases.push_back({"Metal, a field", {Branch::metal}, true, true, true});
  cases.push_back(
      {"all six, mixed", {Branch::jelly, Branch::metal, Branch::sand, Branch::foam, Branch::snow, Branch::plasticine}});
  for (const int size : sizes) {
    // Enough of them that the first touch of memory does not count.
    const int steps = size > 50000 ? 240 : 1000;
    for (const int threads : thread_counts) {
      const bool all = threads > 1;
      for (const BenchCase& c : cases) report(c, size, Precision::single, threads, steps, fma[0][all]);
      report(cases.front(), size, Precision::full, threads, steps, fma[1][all]);
    }
  }
  return 0;
}
