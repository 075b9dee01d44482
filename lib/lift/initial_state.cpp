#include "lift/initial_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/error.h"
#include "lift/filling.h"
#include "scene/neighbors.h"
#include "scene/placement.h"

namespace physmas::lift {
namespace {

void report_filling(const Filling& filling, const Inventory& inventory, const RunSpecification& run, State& state) {
  using Verdict = Filling::Report::Verdict;
  for (size_t o = 0; o < filling.objects.size(); ++o) {
    const Filling::Report& report = filling.objects[o];
    const std::string what = "filling of " + inventory.objects[o].id;
    if (report.verdict == Verdict::solid) {
      state.omitted.push_back(
          {what, fmt::format("already solid: {:.0f} % of its inner cells hold a Gaussian", 100 * report.solidity)});
    }
    if (report.verdict == Verdict::open) state.omitted.push_back({what, "thin or open: it encloses nothing"});
    if (report.verdict == Verdict::none) state.omitted.push_back({what, "no Gaussian belongs to it"});
  }
  const long filled = static_cast<long>(filling.position.size());
  const double full = run.particles.per_cell * std::pow(filling.spacing / run.grid.dx(), 3);
  if (filled > 0 && filling.kept < 0.999 * std::min(1.0, full)) {
    state.omitted.push_back(
        {"full filling density",
         fmt::format("particles.max = {} leaves {:.1f} instead of {} particles per cell", run.particles.max,
                     filling.kept / std::min(1.0, full) * run.particles.per_cell, run.particles.per_cell)});
  }
}

}  // namespace

State initial_state(const Gaussians& gaussians, const Labels& labels, const Inventory& inventory,
                    const RunSpecification& run, const std::string& file) {
  const size_t n = gaussians.size();
  if (n > static_cast<size_t>(run.particles.max)) {
    throw invalid_input({file, "", fmt::format("{} Gaussians", n),
                         fmt::format("at most {}, the run's particles.max", run.particles.max),
                         "raise particles.max, or prune the Gaussians"});
  }
  State state;
  state.map = solver_map(gaussians, run);
  state.row_keys = inventory.row_keys();
  state.gaussian_object = labels.object;
  state.gaussian_row = labels.row;
  state.gaussian_confidence = labels.confidence;
  state.object = labels.object;
  state.row = labels.row;
  state.position.resize(n);
  state.source.resize(n);
  for (size_t i = 0; i < n; ++i) {
    state.position[i] = state.map.to_solver(gaussians.position[i].cast<double>()).cast<float>();
    state.source[i] = static_cast<int32_t>(i);
  }
  const std::vector<Eigen::Vector3f> means = state.position;
  if (run.particles.fill) {
    const int objects = static_cast<int>(inventory.objects.size());
    const Filling filling = fill_objects(gaussians, means, labels.object, objects, state.map, run);
    report_filling(filling, inventory, run, state);
    std::vector<std::vector<int32_t>> members(objects);
    for (size_t i = 0; i < n; ++i) members[labels.object[i]].push_back(static_cast<int32_t>(i));
    std::vector<std::unique_ptr<NeighborSearch<3>>> searches;
    for (const std::vector<int32_t>& list : members)
      searches.push_back(std::make_unique<NeighborSearch<3>>(means, list));
    const size_t filled = filling.position.size();
    state.position.insert(state.position.end(), filling.position.begin(), filling.position.end());
    state.object.insert(state.object.end(), filling.object.begin(), filling.object.end());
    state.source.resize(n + filled);
    state.row.resize(n + filled);
#pragma omp parallel for schedule(dynamic, 256)
    for (size_t k = 0; k < filled; ++k) {
      state.source[n + k] = searches[filling.object[k]]->nearest(filling.position[k], 1).front().index;
      state.row[n + k] = labels.row[state.source[n + k]];
    }
  } else {
    state.omitted.push_back({"filling", "the run's particles.fill is false"});
  }
  state.volume = rest_volumes(state.position, state.map);
  return state;
}

}  // namespace physmas::lift
