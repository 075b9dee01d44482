#include "masks/mask_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physmas::masks {
namespace {

double area_of(const Detection& d) {
  return std::max(0.0, d.x1 - d.x0) * std::max(0.0, d.y1 - d.y0);
}

double overlap(const Detection& a, const Detection& b) {
  const Detection common{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1), 0, ""};
  const double both = area_of(common);
  return both > 0 ? both / (area_of(a) + area_of(b) - both) : 0;
}

double score_at(const remote::Tensor& scores, size_t i, const std::string& source) {
  const double score = scores.numbers[i];
  if (score >= 0 && score <= 1) return score;
  throw remote::provider_error(source, fmt::format("/outputs/scores/data/{}: found {}, expected 0..1", i, score));
}

}  // namespace

std::vector<Detection> detections_from(const std::map<std::string, remote::Tensor>& tensors, int width, int height,
                                       const std::string& source) {
  const remote::Tensor &boxes = tensors.at("boxes"), &scores = tensors.at("scores"), &phrases = tensors.at("phrases");
  const size_t n = scores.numbers.size();
  if (boxes.numbers.size() != 4 * n || phrases.texts.size() != n) {
    throw remote::provider_error(source, fmt::format("/outputs: found {} boxes, {} scores and {} phrases, expected the "
                                                     "same number of each, phrases of datatype BYTES",
                                                     boxes.numbers.size() / 4, n, phrases.texts.size()));
  }
  std::vector<Detection> all;
  for (size_t i = 0; i < n; ++i) {
    const double* b = &boxes.numbers[4 * i];
    if (!std::all_of(b, b + 4, [](double x) { return std::isfinite(x); }) || b[0] > b[2] || b[1] > b[3]) {
      throw remote::provider_error(source, fmt::format("/outputs/boxes/data/{}: found ({}, {}, {}, {}), expected "
                                                       "x0 <= x1 and y0 <= y1 in pixels",
                                                       i, b[0], b[1], b[2], b[3]));
    }
    Detection d{std::clamp(b[0], 0.0, double(width)), std::clamp(b[1], 0.0, double(height)),
                std::clamp(b[2], 0.0, double(width)), std::clamp(b[3], 0.0, double(height)),
                score_at(scores, i, source),          phrases.texts[i]};
    if (d.score >= kBoxThreshold && area_of(d) > 0) all.push_back(std::move(d));
  }
  std::stable_sort(all.begin(), all.end(), [](const Detection& a, const Detection& b) { return a.score > b.score; });
  std::vector<Detection> kept;
  for (const Detection& d : all) {
    if (kept.size() == kMaxBoxes) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const Detection& k) { return overlap(k, d) > kOverlapThreshold; }))
      kept.push_back(d);
  }
  return kept;
}

std::vector<Mask> masks_from(const std::map<std::string, remote::Tensor>& tensors, const std::vector<Detection>& boxes,
                             int width, int height, const std::string& source) {
  const remote::Tensor &masks = tensors.at("masks"), &scores = tensors.at("scores");
  const size_t pixels = static_cast<size_t>(width) * height;
  if (masks.numbers.size() != boxes.size() * pixels || scores.numbers.size() != boxes.size())
    throw remote::provider_error(source, "/outputs: found tensors without numbers, expected masks and scores");
  std::vector<Mask> all;
  for (size_t i = 0; i < boxes.size(); ++i) {
    Mask mask;
    mask.width = width;
    mask.height = height;
    mask.confidence = boxes[i].score * score_at(scores, i, source);
    mask.source = "models";
    mask.pixels.resize(pixels);
    const double* values = &masks.numbers[i * pixels];
    for (size_t p = 0; p < pixels; ++p) mask.pixels[p] = values[p] > 0.5 ? 255 : 0;  // NaN is outside
    all.push_back(mask.area() > 0 ? std::move(mask) : Mask());
  }
  return all;
}

MaskModels::MaskModels(remote::Backend& detector, remote::Backend& segmenter, remote::TensorForm form)
    : detector_(detector, "detector", form), segmenter_(segmenter, "segmenter", form) {
  detector_.require_model({"image", "prompt"}, {"boxes", "scores", "phrases"});
  segmenter_.require_model({"image", "boxes"}, {"masks", "scores"});
}

std::vector<Mask> MaskModels::find(const std::string& name, const std::string& png, const std::string& text, int width,
                                   int height) {
  const std::vector<Detection> boxes =
      detections_from(detector_.infer(name, {{"image", {1}, {png}, {}, {}}, {"prompt", {1}, {}, {text}, {}}},
                                      {{"boxes", {-1, 4}}, {"scores", {-1}}, {"phrases", {-1}}}),
                      width, height, "detector_" + name);
  if (boxes.empty()) return {};
  const long n = static_cast<long>(boxes.size());
  std::vector<double> corners;
  for (const Detection& d : boxes) corners.insert(corners.end(), {d.x0, d.y0, d.x1, d.y1});
  std::vector<Mask> masks =
      masks_from(segmenter_.infer(name, {{"image", {1}, {png}, {}, {}}, {"boxes", {n, 4}, {}, {}, corners}},
                                  {{"masks", {n, height, width}}, {"scores", {n}}}),
                 boxes, width, height, "segmenter_" + name);
  masks.erase(std::remove_if(masks.begin(), masks.end(), [](const Mask& m) { return m.empty(); }), masks.end());
  return masks;
}

}  // namespace physmas::masks
