#include "screen/decide.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "screen/advice.h"
#include "screen/gates.h"

namespace physmas::screen {
namespace {

// Indices from the best score to the worst, first appearance breaking ties.
std::vector<size_t> ranked(const std::vector<ScreenedCandidate>& candidates) {
  std::vector<size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return candidates[a].score > candidates[b].score; });
  return order;
}

std::string failed_gates(const ScreenedCandidate& candidate) {
  std::string names;
  for (const ScreenedCandidate::Gate& gate : candidate.gates) {
    if (!gate.passed) names += (names.empty() ? "" : ", ") + gate.name;
  }
  return names.empty() ? "all gates passed" : "failed gates: " + names;
}

}  // namespace

std::vector<std::string> route_repairs(const ScreenedCandidate& screened, double tau) {
  std::vector<std::string> routes;
  if (!gate_passed(screened, "support")) routes.insert(routes.end(), {"support-stiffness", "rigid-support"});
  if (!gate_passed(screened, "spread") || !gate_passed(screened, "flattening"))
    routes.insert(routes.end(), {"elastic-cohesion", "higher-cohesion"});
  if (!gate_passed(screened, "process") || !gate_passed(screened, "numerical")) routes.push_back("solver-stability");
  if (routes.empty() && screened.score < tau) routes.push_back("role-balanced");
  return routes;
}

ScreenRecord decide_round(const std::vector<Executed>& executed, const SceneRecords& scene, int round, int rounds) {
  ScreenRecord record;
  record.round = round;
  record.tau = scene.tau;
  record.weights.assign(scene.weights.begin(), scene.weights.end());
  for (const Executed& e : executed) {
    ScreenedCandidate screened;
    screened.id = e.candidate.id;
    screened.transform = e.candidate.transform;
    screened.order = e.candidate.order;
    screened.round = e.candidate.round;
    score_candidate(screened, e, scene);
    check_gates(screened, e, scene);
    screened.admitted = screened.valid && screened.score >= scene.tau;
    if (screened.valid && !screened.admitted) screened.advice = advice_for("score", e.execution);
    record.candidates.push_back(std::move(screened));
  }
  const std::vector<size_t> order = ranked(record.candidates);
  for (size_t i = 0; i < order.size(); ++i) record.candidates[order[i]].rank = static_cast<int>(i) + 1;

  const auto admitted =
      std::find_if(order.begin(), order.end(), [&](size_t i) { return record.candidates[i].admitted; });
  if (admitted != order.end()) {
    const ScreenedCandidate& best = record.candidates[*admitted];
    record.decision = "accept";
    record.accepted = best.id;
    record.reason = fmt::format("{} is the best admitted candidate, Q {:.4f}", best.id, best.score);
    return record;
  }
  const ScreenedCandidate& base = record.candidates[order.front()];
  record.reason = fmt::format("none of {} candidates was admitted; the best is {}, Q {:.4f} (tau {}), {}",
                              record.candidates.size(), base.id, base.score, scene.tau, failed_gates(base));
  if (round + 1 < rounds) {
    record.decision = "repair";
    record.repair_base = base.id;
    record.repair_routes = route_repairs(base, scene.tau);
  } else {
    record.decision = "fail";
  }
  return record;
}

}  // namespace physmas::screen
