#include "lift/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "lift/agreement.h"
#include "lift/evidence.h"
#include "scene/color.h"
#include "scene/neighbors.h"
#include "splat/visibility.h"

namespace physmas::lift {
namespace {

constexpr int32_t kNone = -1;

// Whether a view has no mask at all.
bool is_empty(const ViewMasks& view) {
  const auto has_none = [](const std::vector<Mask>& masks) {
    return std::all_of(masks.begin(), masks.end(), [](const Mask& mask) { return mask.area() == 0; });
  };
  return has_none(view.objects) && has_none(view.rows);
}

// One decision per Gaussian among competing labels (objects, or the rows of one object).
struct Decision {
  std::vector<int32_t> best;    // [n] index of the winning label, kNone when nothing supports any
  std::vector<float> margin;    // [n] (best - second)/best, 0 when nothing supports any
  std::vector<float> evidence;  // [n] the winner's support, summed over views, without the tie-break
};

// The support of every label over all views.
class Evidence {
 public:
  // masks[v][k]: mask of label k in view v.
  explicit Evidence(const std::vector<std::vector<const Mask*>>& masks) : support_(masks.size()) {
    const size_t labels = masks.empty() ? 0 : masks[0].size();
    tie_break_.assign(labels, 0);
    for (size_t v = 0; v < masks.size(); ++v) support_[v].resize(labels);
#pragma omp parallel for collapse(2) schedule(dynamic)
    for (size_t v = 0; v < masks.size(); ++v) {
      for (size_t k = 0; k < labels; ++k) support_[v][k] = support_of(*masks[v][k]);
    }
    for (size_t k = 0; k < labels; ++k) {
      long area = 0;
      for (size_t v = 0; v < masks.size(); ++v) area += masks[v][k]->area();
      tie_break_[k] = kAreaTieBreak / static_cast<double>(std::max(1L, area));
    }
  }

  // pixels[v][i]; members: the Gaussians to decide.
  Decision decide(const std::vector<std::vector<int32_t>>& pixels, const std::vector<int32_t>& members) const {
    const size_t labels = tie_break_.size();
    Decision decision;
    decision.best.assign(members.size(), kNone);
    decision.margin.assign(members.size(), 0);
    decision.evidence.assign(members.size(), 0);
#pragma omp parallel for schedule(static)
    for (size_t m = 0; m < members.size(); ++m) {
      double best = 0, second = 0, supported = 0;
      int32_t winner = kNone;
      for (size_t k = 0; k < labels; ++k) {
        double sum = 0;
        bool seen = false;
        for (size_t v = 0; v < support_.size(); ++v) {
          const int32_t pixel = pixels[v][members[m]];
          if (pixel < 0) continue;
          seen = true;
          if (!support_[v][k].empty()) sum += support_[v][k][pixel];
        }
        const double score = seen ? sum + tie_break_[k] : 0;
        if (score > best) {
          second = best;
          best = score;
          winner = static_cast<int32_t>(k);
          supported = sum;
        } else {
          second = std::max(second, score);
        }
      }
      // The tie-break orders labels, it is no evidence: without support the neighbours decide.
      if (supported <= 0) continue;
      decision.best[m] = winner;
      decision.margin[m] = static_cast<float>((best - second) / best);
      decision.evidence[m] = static_cast<float>(supported);
    }
    return decision;
  }

 private:
  std::vector<std::vector<std::vector<float>>> support_;  // [view][label][pixel]
  std::vector<double> tie_break_;                         // [label]
};

// Ambiguous members take the vote of reliable ones among their `count` nearest members, all at once. A vote weighs the
// voter's margin, falling off with distance relative to the farthest neighbour. Returns how many changed or got a
// label.
long vote(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& members, int count, size_t labels,
          Decision& decision) {
  std::vector<int32_t> position(means.size(), kNone);
  for (size_t m = 0; m < members.size(); ++m) position[members[m]] = static_cast<int32_t>(m);
  const NeighborSearch<3> search(means, members);
  std::vector<int32_t> voted = decision.best;
  long changed = 0;
#pragma omp parallel for schedule(dynamic, 256) reduction(+ : changed)
  for (size_t m = 0; m < members.size(); ++m) {
    if (decision.best[m] != kNone && decision.margin[m] >= kAmbiguousMargin) continue;
    const std::vector<Neighbor> around = search.around(members[m], count);
    if (around.empty()) continue;
    const double reach = std::max(around.back().squared, 1e-30);
    std::vector<double> votes(labels, 0);
    for (const Neighbor& neighbor : around) {
      const int32_t n = position[neighbor.index];
      if (decision.best[n] == kNone || decision.margin[n] < kReliableMargin) continue;
      votes[decision.best[n]] += decision.margin[n] * std::exp(-neighbor.squared / reach);
    }
    const auto most = std::max_element(votes.begin(), votes.end());
    if (*most <= 0) continue;
    voted[m] = static_cast<int32_t>(most - votes.begin());
    changed += voted[m] != decision.best[m];
  }
  decision.best = std::move(voted);
  return changed;
}

// Residual members that a labelled one of the same object is nearest to, the nearest first, up to each row's target.
long rescue(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& members, Decision& decision) {
  struct Candidate {
    double squared;
    size_t member;
    int32_t label;
  };
  std::vector<int32_t> labelled;
  std::vector<int32_t> label_of(means.size(), kNone);
  for (size_t m = 0; m < members.size(); ++m) {
    label_of[members[m]] = decision.best[m];
    if (decision.best[m] != kNone) labelled.push_back(members[m]);
  }
  if (labelled.empty() || labelled.size() == members.size()) return 0;
  const NeighborSearch<3> search(means, labelled);
  std::vector<Candidate> candidates;
  for (size_t m = 0; m < members.size(); ++m) {
    if (decision.best[m] != kNone) continue;
    const Neighbor nearest = search.nearest(means[members[m]], 1).front();
    candidates.push_back({nearest.squared, m, label_of[nearest.index]});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.squared < b.squared; });
  std::vector<long> eligible, taken;
  for (const Candidate& c : candidates) {
    if (static_cast<size_t>(c.label) >= eligible.size()) eligible.resize(c.label + 1, 0);
    ++eligible[c.label];
  }
  taken.resize(eligible.size(), 0);
  long rescued = 0;
  for (const Candidate& c : candidates) {
    if (taken[c.label] >= rescue_target(eligible[c.label], static_cast<long>(means.size()))) continue;
    ++taken[c.label];
    ++rescued;
    decision.best[c.member] = c.label;
  }
  return rescued;
}

// Place and look of every Gaussian, in units that make both count: a tenth of the scene's size, and the difference
// between two shades of one paint. The look is the chromaticity of the colour at degree 0 (shading scales all channels
// alike) with a little lightness.
std::vector<Eigen::Matrix<float, 6, 1>> places_and_looks(const Gaussians& gaussians) {
  constexpr float kPlaceUnit = 0.1f, kLookUnit = 0.04f, kLightness = 0.05f;
  Eigen::Vector3f low = gaussians.position[0], high = low;
  for (const Eigen::Vector3f& p : gaussians.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const float unit = std::max(kPlaceUnit * (high - low).norm(), std::numeric_limits<float>::min());
  std::vector<Eigen::Matrix<float, 6, 1>> features(gaussians.size());
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const Eigen::Vector3f color = gaussians.base_color(i);
    const float lightness = color.cwiseMax(0.02f).cwiseMin(1.0f).mean();
    const Eigen::Vector3f look = chromaticity(color) + Eigen::Vector3f::Constant(kLightness * lightness);
    features[i] << gaussians.position[i] / unit, look / kLookUnit;
  }
  return features;
}

// Members that are hidden take the vote of the reliable, seen members that are nearest to them in place and look:
// what lies behind a surface belongs to the part that it looks like, and among parts of one look to the nearest.
void vote_for_hidden(const std::vector<Eigen::Matrix<float, 6, 1>>& features, const std::vector<int32_t>& members,
                     const std::vector<uint8_t>& hidden, int count, size_t labels, Decision& decision) {
  std::vector<int32_t> seen, label_of(features.size(), kNone);
  for (size_t m = 0; m < members.size(); ++m) {
    const bool reliable = decision.best[m] != kNone && decision.margin[m] >= kReliableMargin;
    if (hidden[members[m]] != 0 || !reliable) continue;
    seen.push_back(members[m]);
    label_of[members[m]] = decision.best[m];
  }
  const NeighborSearch<6> search(features, seen);
  if (search.empty()) return;
#pragma omp parallel for schedule(dynamic, 256)
  for (size_t m = 0; m < members.size(); ++m) {
    if (hidden[members[m]] == 0) continue;
    const std::vector<Neighbor> nearest = search.nearest(features[members[m]], count);
    const double reach = std::max(nearest.back().squared, 1e-30);
    std::vector<double> votes(labels, 0);
    for (const Neighbor& n : nearest) votes[label_of[n.index]] += std::exp(-n.squared / reach);
    decision.best[m] = static_cast<int32_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
  }
}

// Objects for the Gaussians that nothing decided: that of the nearest decided one, the first object if there is none.
void give_nearest_object(const std::vector<Eigen::Vector3f>& means, std::vector<int32_t>& object) {
  std::vector<int32_t> decided;
  for (size_t i = 0; i < object.size(); ++i) {
    if (object[i] != kNone) decided.push_back(static_cast<int32_t>(i));
  }
  const NeighborSearch<3> search(means, decided);
  std::vector<int32_t> given = object;
#pragma omp parallel for schedule(dynamic, 256)
  for (size_t i = 0; i < object.size(); ++i) {
    if (object[i] == kNone) given[i] = search.empty() ? 0 : object[search.nearest(means[i], 1).front().index];
  }
  object = std::move(given);
}

}  // namespace

long rescue_target(long candidates, long gaussians) {
  return std::min(candidates, std::max(kRescueLeast, std::lround(kRescueShare * static_cast<double>(gaussians))));
}

int residual_row_of(const Inventory& inventory, int o) {
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].residual && inventory.rows[r].object == inventory.objects[o].id) return static_cast<int>(r);
  }
  return -1;
}

Labels assign_rows(const LiftingInput& input) {
  const std::vector<Eigen::Vector3f>& means = input.gaussians.position;
  const Inventory& inventory = input.inventory;
  const std::vector<ViewMasks>& views = input.views;
  const size_t n = means.size(), objects = inventory.objects.size();
  std::vector<std::vector<int32_t>> pixels;
  for (const Camera& camera : input.cameras) pixels.push_back(splat::project_to_pixels(means, camera));
  Labels labels;
  std::vector<uint8_t> in_image(n, 0), hidden(n, 0);
  std::vector<int> views_of(n, 0);  // |Omega_i|
  const bool depth_test = input.occlusion == RunSpecification::Lifting::Occlusion::depth;
  const std::vector<std::vector<uint8_t>> visible =
      depth_test ? splat::visible_in_views(input.gaussians, input.cameras) : std::vector<std::vector<uint8_t>>();
  for (size_t v = 0; v < pixels.size(); ++v) {
    for (size_t i = 0; i < n; ++i) {
      if (pixels[v][i] < 0) continue;
      in_image[i] = 1;
      if (depth_test && visible[v][i] == 0) pixels[v][i] = -1;
    }
  }
  // What nothing else sees is then a hidden Gaussian's case.
  if (depth_test) {
    labels.agreement = compare_views(views, pixels);
    const std::vector<size_t>& contradicted = labels.agreement.contradicted;
    for (size_t v = 0; v < views.size(); ++v) {
      const bool is_contradicted = std::find(contradicted.begin(), contradicted.end(), v) != contradicted.end();
      if (is_contradicted || is_empty(views[v])) pixels[v].assign(n, -1);
    }
  }
  for (const std::vector<int32_t>& pixel : pixels) {
    for (size_t i = 0; i < n; ++i) views_of[i] += pixel[i] >= 0;
  }
  for (size_t i = 0; i < n; ++i) {
    hidden[i] = in_image[i] != 0 && views_of[i] == 0;
    labels.counts.hidden += hidden[i];
    labels.counts.unseen += in_image[i] == 0;
  }
  const std::vector<Eigen::Matrix<float, 6, 1>> features = places_and_looks(input.gaussians);
  labels.row.assign(n, kNone);
  labels.confidence.assign(n, 0);

  // Eq. (objectscore)
  std::vector<std::vector<const Mask*>> object_masks(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    for (const Mask& mask : views[v].objects) object_masks[v].push_back(&mask);
  }
  std::vector<int32_t> everyone(n);
  for (size_t i = 0; i < n; ++i) everyone[i] = static_cast<int32_t>(i);
  Decision by_object = Evidence(object_masks).decide(pixels, everyone);
  labels.counts.object_votes = vote(means, everyone, kObjectNeighbors, objects, by_object);
  if (labels.counts.hidden > 0) vote_for_hidden(features, everyone, hidden, kObjectNeighbors, objects, by_object);
  labels.object = by_object.best;
  give_nearest_object(means, labels.object);

  // Eq. (partscore), within each object
  for (size_t o = 0; o < objects; ++o) {
    const int residual = residual_row_of(inventory, static_cast<int>(o));
    if (residual < 0) throw internal_error("object " + inventory.objects[o].id + " without a residual row");
    std::vector<int32_t> rows, members;
    for (size_t r = 0; r < inventory.rows.size(); ++r) {
      if (inventory.rows[r].object == inventory.objects[o].id && !inventory.rows[r].residual)
        rows.push_back(static_cast<int32_t>(r));
    }
    for (size_t i = 0; i < n; ++i) {
      if (labels.object[i] == static_cast<int32_t>(o)) members.push_back(static_cast<int32_t>(i));
    }
    std::vector<std::vector<const Mask*>> part_masks(views.size());
    for (size_t v = 0; v < views.size(); ++v) {
      for (const int32_t r : rows) part_masks[v].push_back(&views[v].rows[r]);
    }
    Decision by_part = Evidence(part_masks).decide(pixels, members);
    const std::vector<int32_t> by_evidence = by_part.best;
    labels.counts.part_votes += vote(means, members, kPartNeighbors, rows.size(), by_part);
    if (labels.counts.hidden > 0) vote_for_hidden(features, members, hidden, kPartNeighbors, rows.size(), by_part);
    labels.counts.rescued += rescue(means, members, by_part);
    for (size_t m = 0; m < members.size(); ++m) {
      const int32_t i = members[m];
      const bool is_residual = by_part.best[m] == kNone;
      labels.row[i] = is_residual ? residual : rows[by_part.best[m]];
      const float mean = views_of[i] > 0 ? by_part.evidence[m] / static_cast<float>(views_of[i]) : 0.0f;
      // What neighbours decided rests on no evidence of its own.
      const bool capped = is_residual || by_part.best[m] != by_evidence[m];
      labels.confidence[i] = std::min(mean, static_cast<float>(capped ? kResidualConfidenceCap : 1.0));
      labels.counts.residual += is_residual;
    }
  }
  return labels;
}

}  // namespace physmas::lift
