#include "mpm/companion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace physmas::mpm {

Companion make_companion(const Problem& problem, int factor) {
  Companion companion;
  companion.problem = problem;
  Domain& domain = companion.problem.domain;
  domain.n = std::max(8, domain.n / factor);
  // Walls stay where they are, as far as whole cells allow.
  domain.wall_cells = std::max(2, (problem.domain.wall_cells + factor - 1) / factor);

  const Particles& fine = problem.particles;
  Particles& coarse = companion.problem.particles;
  coarse = {};
  double volume = 0;
  for (const double v : fine.volume) volume += v;
  const double edge = factor * std::cbrt(volume / static_cast<double>(std::max<size_t>(1, fine.size())));
  std::map<std::tuple<int, long, long, long>, int> index_of;
  companion.group.reserve(fine.size());
  for (size_t i = 0; i < fine.size(); ++i) {
    const auto cell = [&](int axis) { return static_cast<long>(std::floor(fine.position[i][axis] / edge)); };
    const auto [at, is_new] =
        index_of.try_emplace({fine.row[i], cell(0), cell(1), cell(2)}, static_cast<int>(coarse.position.size()));
    if (is_new) {
      coarse.position.push_back({0, 0, 0});
      coarse.volume.push_back(0);
      coarse.row.push_back(fine.row[i]);
      if (!fine.velocity.empty()) coarse.velocity.push_back({0, 0, 0});
      if (!fine.material.empty()) coarse.material.push_back({fine.material[i].branch, 0, 0, 0});
    }
    const int q = at->second;
    companion.group.push_back(q);
    coarse.volume[q] += fine.volume[i];
    coarse.position[q] = coarse.position[q] + fine.volume[i] * fine.position[i];
    if (!fine.velocity.empty()) coarse.velocity[q] = coarse.velocity[q] + fine.volume[i] * fine.velocity[i];
    if (!fine.material.empty()) {
      coarse.material[q].E += fine.volume[i] * fine.material[i].E;
      coarse.material[q].nu += fine.volume[i] * fine.material[i].nu;
      coarse.material[q].rho += fine.volume[i] * fine.material[i].rho;
    }
  }
  for (size_t q = 0; q < coarse.size(); ++q) {
    coarse.position[q] = (1 / coarse.volume[q]) * coarse.position[q];
    if (!coarse.velocity.empty()) coarse.velocity[q] = (1 / coarse.volume[q]) * coarse.velocity[q];
    if (coarse.material.empty()) continue;
    for (double* number : {&coarse.material[q].E, &coarse.material[q].nu, &coarse.material[q].rho})
      *number /= coarse.volume[q];
  }
  return companion;
}

PointPaths run_companion(const Companion& companion, const Particles& rest, size_t points, const Timing& timing,
                         const Device& device, Result* result) {
  Options options;
  options.device = device;
  options.track_total_F = true;
  options.measure_energy = false;
  PointPaths paths;
  const std::vector<Vec3d>& origin = companion.problem.particles.position;
  Result done = run(companion.problem, timing, options, [&](const Frame& frame) {
    std::vector<Vec3d> x(points);
    for (size_t i = 0; i < points; ++i) {
      const int q = companion.group[i];
      x[i] = frame.state.x[q] + frame.state.total_F[q] * (rest.position[i] - origin[q]);
    }
    paths.push_back(std::move(x));
  });
  if (result) *result = std::move(done);
  return paths;
}

}  // namespace physmas::mpm
