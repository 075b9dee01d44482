#include "metrics/clip.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace physmas::metrics {
namespace {

// Length of a vector; 0 when it has no direction.
double length(const std::vector<double>& v) {
  double square = 0;
  for (const double x : v) square += x * x;
  return std::isfinite(square) ? std::sqrt(square) : 0;
}

}  // namespace

ClipEmbeddings load_clip_embeddings(const std::string& path) {
  return clip_embeddings_from(load_arrays(path, {"text", "frames"}), path);
}

ClipEmbeddings clip_embeddings_from(const std::map<std::string, Array>& arrays, const std::string& file) {
  const Array &text = arrays.at("text"), &frames = arrays.at("frames");
  const bool is_vector = text.shape.size() == 1 || (text.shape.size() == 2 && text.shape[0] == 1);
  if (!is_vector || text.values.empty()) throw invalid_input({file, "text", shape_text(text.shape), "[D] or [1, D]"});
  const size_t D = text.values.size();
  if (frames.shape.size() != 2 || frames.shape[1] != D)
    throw invalid_input({file, "frames", shape_text(frames.shape), fmt::format("[T, {}] as the text", D)});
  ClipEmbeddings embeddings;
  embeddings.text = text.values;
  for (size_t t = 0; t < frames.shape[0]; ++t)
    embeddings.frames.emplace_back(frames.values.begin() + static_cast<long>(t * D),
                                   frames.values.begin() + static_cast<long>((t + 1) * D));
  return embeddings;
}

Measurement clip_similarity(const ClipEmbeddings& embeddings) {
  Measurement m;
  const double text = length(embeddings.text);
  if (!(text > 0)) m.reason = "the text's embedding has no direction";
  if (embeddings.frames.empty()) m.reason = "no frames";
  double sum = 0;
  for (size_t t = 0; t < embeddings.frames.size() && m.reason.empty(); ++t) {
    const std::vector<double>& frame = embeddings.frames[t];
    const double size = length(frame);
    if (!(size > 0)) m.reason = fmt::format("the embedding of frame {} has no direction", t);
    double product = 0;
    for (size_t k = 0; k < frame.size(); ++k) product += frame[k] * embeddings.text[k];
    sum += product / (size * text);
  }
  if (!m.reason.empty()) return m;
  m.valid = true;
  m.samples = static_cast<long>(embeddings.frames.size());
  m.value = sum / static_cast<double>(m.samples);
  return m;
}

}  // namespace physmas::metrics
