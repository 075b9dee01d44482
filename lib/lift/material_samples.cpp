#include "lift/material_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "scene/neighbors.h"

namespace physmas::lift {
namespace {

// Median distance from a sample to the nearest other one, over some thousands of them.
double sample_spacing(const std::vector<Eigen::Vector3f>& samples, const NeighborSearch<3>& search) {
  constexpr size_t kMeasured = 4096;
  if (samples.size() < 2) return 0;
  const size_t stride = (samples.size() + kMeasured - 1) / kMeasured, measured = (samples.size() + stride - 1) / stride;
  std::vector<double> squared(measured);
#pragma omp parallel for
  for (size_t k = 0; k < measured; ++k) squared[k] = search.around(static_cast<int32_t>(k * stride), 1).front().squared;
  std::nth_element(squared.begin(), squared.begin() + static_cast<long>(measured / 2), squared.end());
  return std::sqrt(squared[measured / 2]);
}

}  // namespace

ParticleField sample_particles(const MaterialField& field, const State& state, const RunSpecification& run,
                               const std::string& file) {
  constexpr double kSpacings = 2, kLeastCells = 2;
  std::vector<Eigen::Vector3f> samples(field.size());
  for (size_t i = 0; i < samples.size(); ++i)
    samples[i] = state.map.to_solver(field.position[i].cast<double>()).cast<float>();
  std::vector<int32_t> all(samples.size());
  std::iota(all.begin(), all.end(), 0);
  const NeighborSearch<3> search(samples, std::move(all));
  ParticleField particles;
  const double cell = run.grid.dx();
  particles.reach = run.lifting.field_reach ? *run.lifting.field_reach * cell
                                            : std::max(kLeastCells * cell, kSpacings * sample_spacing(samples, search));
  const size_t count = state.particle_count();
  particles.E.assign(count, 0), particles.nu.assign(count, 0), particles.rho.assign(count, 0);
#pragma omp parallel for schedule(dynamic, 256)
  for (size_t q = 0; q < count; ++q) {
    const Neighbor nearest = search.nearest(state.position[q], 1).front();
    if (!(nearest.squared <= particles.reach * particles.reach)) continue;
    particles.E[q] = field.E[nearest.index];
    particles.nu[q] = field.nu[nearest.index];
    particles.rho[q] = field.rho[nearest.index];
  }
  if (std::all_of(particles.E.begin(), particles.E.end(), [](float E) { return E == 0; })) {
    throw invalid_input(
        {file, "/samples/position",
         fmt::format("no sample within {:.3g} (scene units) of any particle", particles.reach / state.map.s),
         "samples where the Gaussians are, in their coordinates"});
  }
  return particles;
}

}  // namespace physmas::lift
