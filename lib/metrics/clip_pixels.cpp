// CLIP's preprocessing of pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "metrics/clip.h"

namespace physmas::metrics {
namespace {

constexpr int kPrecision = 22;  // bits of Pillow's fixed-point weights for 8-bit pictures
constexpr int kMaxRatio =
    16;  // of the sides: the crop leaves nearly nothing of longer ones, and their resizing is costly
constexpr double kMean[] = {0.48145466, 0.4578275, 0.40821073};
constexpr double kDeviation[] = {0.26862954, 0.26130258, 0.27577711};

double bicubic(double x) {
  constexpr double a = -0.5;
  x = std::fabs(x);
  if (x < 1) return ((a + 2) * x - (a + 3)) * x * x + 1;
  if (x < 2) return (((x - 5) * x + 8) * x - 4) * a;
  return 0;
}

struct Weights {
  int first = 0;
  std::vector<int> weight;  // fixed point
};

std::vector<Weights> resampling_weights(int in, int out) {
  const double scale = static_cast<double>(in) / out, stretch = std::max(scale, 1.0), support = 2 * stretch;
  std::vector<Weights> list(out);
  for (int i = 0; i < out; ++i) {
    const double center = (i + 0.5) * scale;
    const int first = std::max(0, static_cast<int>(center - support + 0.5));
    const int last = std::min(in, static_cast<int>(center + support + 0.5));
    std::vector<double> weight;
    double sum = 0;
    for (int x = first; x < last; ++x) sum += weight.emplace_back(bicubic((x - center + 0.5) / stretch));
    list[i].first = first;
    for (const double w : weight)
      list[i].weight.push_back(static_cast<int>(w / sum * (1 << kPrecision) + (w < 0 ? -0.5 : 0.5)));
  }
  return list;
}

// Along x, or along y.
Image resampled(const Image& in, int size, bool along_x) {
  const std::vector<Weights> weights = resampling_weights(along_x ? in.width : in.height, size);
  Image out(along_x ? size : in.width, along_x ? in.height : size, 3);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const Weights& w = weights[along_x ? x : y];
      for (int c = 0; c < 3; ++c) {
        int64_t sum = 1 << (kPrecision - 1);
        for (size_t k = 0; k < w.weight.size(); ++k) {
          const int at = w.first + static_cast<int>(k);
          sum += int64_t{w.weight[k]} * (along_x ? in.at(at, y) : in.at(x, at))[c];
        }
        out.at(x, y)[c] = static_cast<uint8_t>(std::clamp<int64_t>(sum >> kPrecision, 0, 255));
      }
    }
  }
  return out;
}

// Half to even, as Python rounds.
int crop_offset(int size) {
  return static_cast<int>(std::nearbyint((size - kClipSize) / 2.0));
}

}  // namespace

std::vector<float> clip_pixels(const Image& frame) {
  const int64_t shortest = std::min(frame.width, frame.height);
  if (std::max(frame.width, frame.height) > kMaxRatio * shortest)
    throw invalid_input({"the video", "", fmt::format("{} x {} pixels", frame.width, frame.height),
                         fmt::format("a longer side of at most {} times the shorter", kMaxRatio)});
  const int width = static_cast<int>(int64_t{kClipSize} * frame.width / shortest);
  const int height = static_cast<int>(int64_t{kClipSize} * frame.height / shortest);
  Image picture = frame.width == width ? frame : resampled(frame, width, true);
  if (picture.height != height) picture = resampled(picture, height, false);
  const int left = crop_offset(width), top = crop_offset(height);
  std::vector<float> pixels;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kClipSize; ++y) {
      for (int x = 0; x < kClipSize; ++x)
        pixels.push_back(static_cast<float>((picture.at(left + x, top + y)[c] / 255.0 - kMean[c]) / kDeviation[c]));
    }
  }
  return pixels;
}

}  // namespace physmas::metrics
