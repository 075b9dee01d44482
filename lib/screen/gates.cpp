#include "screen/gates.h"

#include <algorithm>

#include "records/json.h"
#include "records/support.h"
#include "screen/advice.h"

namespace physmas::screen {
namespace {

constexpr double kSupportE = 1e7;  // Pa
constexpr const char* kExemptTransform = "solver-compatible";

using Gate = ScreenedCandidate::Gate;

Gate plan_gate(const Plan& plan) {
  return {"plan", plan.resolved, {{"resolved", plan.resolved}}, {{"resolved", true}}};
}

Gate process_gate(const ExecutionRecord& execution) {
  return {"process",
          execution.exit == 0 && execution.signal == 0,
          {{"exit", execution.exit}, {"signal", execution.signal}},
          {{"exit", 0}, {"signal", 0}}};
}

Gate numerical_gate(const ExecutionRecord& execution) {
  return {"numerical",
          !execution.diverged && execution.error_tokens.empty(),
          {{"status", execution.diverged ? "diverged" : "stable"}, {"error_tokens", execution.error_tokens}},
          {{"status", "stable"}, {"error_tokens", Json::array()}}};
}

Gate spread_gate(const Endpoints& endpoints) {
  Gate gate{"spread", true, nullptr, {{"area_growth_at_most", kSpreadLimit}}};
  if (!endpoints.valid) return gate;
  gate.measured = {{"area_growth", endpoints.image.area_growth}};
  if (endpoints.own_spread) gate.measured["own_frame"] = {{"area_growth", endpoints.own_spread->area_growth}};
  if (!endpoints.excuse) gate.limit["excuse_rotation"] = false;
  gate.passed = !endpoints.spread();
  return gate;
}

Json height_and_width(const ForegroundRatios& ratios) {
  return {{"height_ratio", ratios.height_ratio}, {"width_ratio", ratios.width_ratio}};
}

Gate flattening_gate(const Endpoints& endpoints) {
  Gate gate{"flattening",
            true,
            nullptr,
            {{"refused_height_ratio_below", kFlatHeight}, {"with_width_ratio_above", kFlatWidth}}};
  if (!endpoints.valid) return gate;
  gate.measured = height_and_width(endpoints.image);
  if (endpoints.own_flattening) gate.measured["own_frame"] = height_and_width(*endpoints.own_flattening);
  if (!endpoints.excuse) gate.limit["excuse_rotation"] = false;
  gate.passed = !endpoints.flattened();
  return gate;
}

Gate support_gate(const Candidate& candidate, const Inventory& inventory) {
  Gate gate{"support", true, nullptr, {{"E_at_least", kSupportE}}};
  const CandidateRow* softest = nullptr;
  for (const CandidateRow& row : candidate.rows) {
    if (!evaluator_support(inventory.rows[row.row], row)) continue;
    if (softest == nullptr || row.E < softest->E) softest = &row;
  }
  if (softest == nullptr) return gate;
  const bool exempt = candidate.transform == kExemptTransform;
  gate.measured = {{"softest_support", softest->key}, {"E", softest->E}, {"exempt", exempt}};
  gate.passed = exempt || softest->E >= kSupportE;
  return gate;
}

Gate share_gate(const char* name, const std::optional<double>& share, double least) {
  return {name, share.value_or(1) >= least, share ? Json({{"share", *share}}) : Json(), {{"share_at_least", least}}};
}

}  // namespace

void check_gates(ScreenedCandidate& screened, const Executed& executed, const SceneRecords& scene) {
  const Endpoints endpoints = endpoints_of(executed.render, scene);
  screened.gates = {
      plan_gate(scene.plan),  process_gate(executed.execution), numerical_gate(executed.execution),
      spread_gate(endpoints), flattening_gate(endpoints),       support_gate(executed.candidate, scene.inventory)};
  if (scene.achieved_min > 0) screened.gates.push_back(share_gate("achieved", screened.achieved, scene.achieved_min));
  if (scene.least_stillness() > 0)
    screened.gates.push_back(share_gate("stillness", screened.stillness, scene.least_stillness()));
  for (Gate& gate : screened.gates) {
    if (!gate.passed) gate.advice = advice_for(gate.name, executed.execution);
  }
  screened.valid =
      std::all_of(screened.gates.begin(), screened.gates.end(), [](const Gate& gate) { return gate.passed; });
}

bool gate_passed(const ScreenedCandidate& screened, const char* name) {
  for (const Gate& gate : screened.gates) {
    if (gate.name == name) return gate.passed;
  }
  throw internal_error(std::string("no gate named ") + name);
}

}  // namespace physmas::screen
