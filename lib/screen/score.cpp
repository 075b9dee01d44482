#include "screen/score.h"

#include <algorithm>
#include <functional>
#include <set>

#include "records/support.h"
#include "records/text_match.h"

namespace physmas::screen {
namespace {

constexpr double kPenaltyCap = 0.12, kProjectionPenalty = 0.025, kBondPenalty = 0.035;
constexpr long kSmallVideo = 4096;  // bytes

void score_video(ScreenedCandidate& screened, const RenderRecord& render, const Endpoints& endpoints) {
  const auto add = [&](const char* term, double value) {
    screened.video_terms.emplace_back(term, value);
    screened.video += value;
  };
  screened.video = 0;
  if (render.video.empty()) {
    add("no video", -0.15);
  } else if (render.file_size < kSmallVideo) {
    add("video below 4096 bytes", -0.20);
  } else {
    add("video of at least 4096 bytes", 0.20);
  }
  if (!endpoints.valid) return;
  add("foreground in the first and the last frame", 0.12);
  if (endpoints.spread()) {
    add("foreground area grows above 2.0x", -0.25);
  } else if (endpoints.area_growth() > 1.45) {
    add("foreground area grows above 1.45x", -0.10);
  }
  if (endpoints.flattened()) add("height falls below 0.45x while width exceeds 1.25x", -0.22);
  if (endpoints.image.spread() && !endpoints.spread()) add("foreground area grows above 2.0x by turning", 0);
  if (endpoints.image.flattened() && !endpoints.flattened())
    add("height falls below 0.45x while width exceeds 1.25x by turning", 0);
  if (endpoints.dark_ratio > 0.18) add("dark foreground above 0.18", -0.08);
}

double role_score(const InventoryRow& part, const CandidateRow& row) {
  const RowText name = row_text(part, {part.name});
  if (contains_any(name, {"head", "blade", "tip", "plate", "support", "stand", "tray", "dish", "shell", "frame"}))
    return row.E >= 1e6 && row.branch == Branch::metal ? 1 : 0.35;
  if (contains_any(name, {"rubber", "sole", "tire", "wheel", "foam", "cushion"})) return row.E <= 1e8 ? 1 : 0.5;
  return 0.7;
}

double density_score(const CandidateRow& row) {
  if (row.rho < 250) return 0.35;
  return row.rho > 5000 ? 0.55 : 1;
}

// The solver lookup of a row with C-hat = 1.
double solver_score(const InventoryRow& part, const CandidateRow& row) {
  if (row.label == kPlasticine && contains_any(row_text(part, {part.name}), {"clay", "putty", "plasticine", "dough"}))
    return row.branch == Branch::plasticine ? 1 : 0.7;
  if (row.branch == Branch::jelly) return 1;
  return row.branch == Branch::foam || row.branch == Branch::plasticine ? 0.55 : 0.7;
}

}  // namespace

Endpoints endpoints_of(const RenderRecord& render, const SceneRecords& scene) {
  const FrameForeground *first = render.endpoint(0), *last = render.endpoint(scene.frames - 1);
  Endpoints endpoints;
  const auto image = foreground_ratios(first, last);
  endpoints.valid = image.has_value();
  endpoints.excuse = scene.excuse_rotation;
  if (!image) return endpoints;
  endpoints.image = *image;
  endpoints.dark_ratio = last->dark_ratio;
  if (render.own_frame) {
    endpoints.own_spread = foreground_ratios(first, &render.own_frame->turned_back);
    endpoints.own_flattening = foreground_ratios(first, &render.own_frame->put_back);
  }
  return endpoints;
}

void score_candidate(ScreenedCandidate& screened, const Executed& executed, const SceneRecords& scene) {
  const Candidate& candidate = executed.candidate;
  const double count = static_cast<double>(candidate.rows.size());
  // Means are sums in row order divided by the count.
  const auto mean = [&](const std::function<double(const InventoryRow&, const CandidateRow&)>& score) {
    double sum = 0;
    for (const CandidateRow& row : candidate.rows) sum += score(scene.inventory.rows[row.row], row);
    return sum / count;
  };
  score_video(screened, executed.render, endpoints_of(executed.render, scene));
  screened.part_confidence =
      mean([&](const InventoryRow&, const CandidateRow& row) { return scene.evidence.rows[row.row].part_confidence; });
  std::set<int> labels;
  for (const CandidateRow& row : candidate.rows) labels.insert(row.label);
  screened.diversity = static_cast<double>(labels.size()) / count;
  screened.role = mean(role_score);
  screened.base = candidate.base_confidence;
  screened.density = mean([](const InventoryRow&, const CandidateRow& row) { return density_score(row); });
  double solver = 0;
  int cohesive = 0;
  for (const CandidateRow& row : candidate.rows) {
    const InventoryRow& part = scene.inventory.rows[row.row];
    if (!evaluator_cohesive(part, row)) continue;
    solver += solver_score(part, row);
    ++cohesive;
  }
  screened.solver = cohesive == 0 ? 0.7 : solver / cohesive;

  const auto projected = std::count_if(candidate.projection.begin(), candidate.projection.end(),
                                       [](const auto& entry) { return entry.second > 0; });
  screened.penalty = std::min(kPenaltyCap, kProjectionPenalty * static_cast<double>(projected) +
                                               kBondPenalty * static_cast<double>(candidate.retention.size()));
  const std::array<double, 7> features = {screened.video, screened.part_confidence, screened.diversity, screened.role,
                                          screened.base,  screened.density,         screened.solver};
  screened.score = 0;
  for (size_t i = 0; i < features.size(); ++i) screened.score += scene.weights[i] * features[i];
  screened.score -= screened.penalty;

  // What a motion that broke down had done until then says nothing of what it would have done.
  if (executed.execution.diverged) return;
  for (const AchievedAction& action : executed.execution.achieved)
    screened.achieved = std::min(screened.achieved.value_or(1), action.share);
  if (executed.execution.stillness) screened.stillness = executed.execution.stillness->share;
  // Of a prompt that asks for no motion, standing still is all that there is to achieve.
  if (scene.plan.still) screened.achieved = screened.stillness;
}

}  // namespace physmas::screen
