#include "mpm/material/constitutive.h"
#include "mpm/simulation.h"

namespace physmas::mpm {

std::vector<Omission> omissions(const Problem& problem, const Options& options) {
  std::vector<Omission> list;
  bool used[kBranchCount] = {}, svd = false;
  for (const int row : problem.particles.row) used[static_cast<int>(problem.materials[row].branch)] = true;
  for (int b = 0; b < kBranchCount; ++b) {
    if (!used[b]) list.push_back({std::string("branch ") + kBranchNames[b], "no particle belongs to it"});
    svd = svd || (used[b] && needs_principal_stretches(static_cast<Branch>(b)));
  }
  if (!svd) list.push_back({"principal stretches", "no present branch needs them"});
  if (problem.domain.colliders.empty()) list.push_back({"colliders", "none are configured"});
  if (problem.schedule.actions.empty()) list.push_back({"actions", "none are scheduled"});
  if (problem.schedule.projections.empty()) list.push_back({"structure projection", "no row is projected"});
  if (problem.schedule.retentions.empty()) list.push_back({"interface retention", "no support retains its neighbours"});
  if (!options.track_total_F) list.push_back({"total deformation", "frames hold the elastic one"});
  if (!options.measure_energy && !options.measure_steps) {
    list.push_back({"elastic energy and det F range", "not asked for"});
  }
  if (!options.measure_steps) list.push_back({"energy budget of every substep", "not asked for"});
  return list;
}

}  // namespace physmas::mpm
