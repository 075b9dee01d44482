#include "lift/initial_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <set>

#include "base/error.h"
#include "lift/carriers.h"
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
  const size_t all = gaussians.size(), n = run.particles.simulated(all);
  State state;
  state.map = solver_map(gaussians, run);
  state.row_keys = inventory.row_keys();
  state.gaussian_object = labels.object;
  state.gaussian_row = labels.row;
  state.gaussian_confidence = labels.confidence;
  std::vector<Eigen::Vector3f> means(all);
  for (size_t i = 0; i < all; ++i) means[i] = state.map.to_solver(gaussians.position[i].cast<double>()).cast<float>();
  if (n == all) {
    state.source.resize(n);
    std::iota(state.source.begin(), state.source.end(), 0);
  } else {
    const size_t rows = std::set<int32_t>(labels.row.begin(), labels.row.end()).size();
    if (n < rows) {
      throw invalid_input({file, "", fmt::format("{} Gaussians in {} rows", all, rows),
                           fmt::format("a particles.max of at least {}", 2 * rows), "raise particles.max"});
    }
    state.source = choose_carriers(means, labels.row, n, state.map.length);
    state.carriers = carry(means, labels.row, state.source);
    state.omitted.push_back({"simulation of every Gaussian",
                             fmt::format("{} of {} Gaussians are particles and carry the others: there are more than "
                                         "particles.max = {}",
                                         n, all, run.particles.max)});
  }
  for (const int32_t g : state.source) {
    state.position.push_back(means[g]);
    state.row.push_back(labels.row[g]);
    state.object.push_back(labels.object[g]);
  }
  if (run.particles.fill) {
    const int objects = static_cast<int>(inventory.objects.size());
    const Filling filling = fill_objects(gaussians, means, labels.object, objects, state.map, run);
    report_filling(filling, inventory, run, state);
    std::vector<std::vector<int32_t>> members(objects);
    for (size_t i = 0; i < all; ++i) members[labels.object[i]].push_back(static_cast<int32_t>(i));
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
