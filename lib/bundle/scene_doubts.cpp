#include "bundle/scene_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "splat/middle_box.h"

namespace physmas::bundle {
namespace {

constexpr double kFaint = 0.02;    // a median opacity below it draws nothing
constexpr double kHuge = 0.2;      // a median scale of this part of the scene hides everything else
constexpr int kCovered = 13;       // levels of alpha, of 255
constexpr double kBlank = 5e-4;    // of a picture
constexpr double kOneColor = 1.5;  // levels, standard deviation

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// "blank", "of one colour", or empty.
std::string fault_of(const Image& view) {
  const size_t pixels = view.pixels.size() / 4;
  size_t covered = 0;
  double sum[3] = {}, squares[3] = {};
  for (size_t i = 0; i < pixels; ++i) {
    covered += view.pixels[4 * i + 3] >= kCovered;
    for (int c = 0; c < 3; ++c) {
      const double v = view.pixels[4 * i + c];
      sum[c] += v;
      squares[c] += v * v;
    }
  }
  const double n = static_cast<double>(std::max<size_t>(1, pixels));
  if (static_cast<double>(covered) < kBlank * n) return "blank";
  double spread = 0;
  for (int c = 0; c < 3; ++c)
    spread = std::max(spread, std::sqrt(std::max(0.0, squares[c] / n - sum[c] * sum[c] / n / n)));
  return spread < kOneColor ? "of one colour" : "";
}

}  // namespace

std::string scene_doubt(const Gaussians& g, const std::vector<Image>& views) {
  std::string fault;
  for (const Image& view : views) {
    if (fault.empty()) fault = fault_of(view);
  }
  const std::string seen = fault.empty() ? "" : ": a view is " + fault;
  if (g.size() == 1) return "there is one Gaussian only" + seen + "; is this the file of the trained splat?";
  std::vector<double> opacities(g.size()), scales(g.size());
  for (size_t i = 0; i < g.size(); ++i) {
    opacities[i] = g.opacity(i);
    scales[i] = g.log_scale[i].maxCoeff();
  }
  const double opacity = median_of(std::move(opacities)), scale = std::exp(median_of(std::move(scales)));
  const double size = splat::middle_box(g).sizes().maxCoeff();
  if (scale > kHuge * size) {
    return fmt::format(
        "half of the Gaussians are as large as {:.2g} of a scene of size {:.3g}{}; scales are perhaps stored without "
        "the "
        "logarithm: --read linear-scales takes them so",
        scale / size, size, seen);
  }
  if (opacity < kFaint) {
    return fmt::format(
        "half of the Gaussians have an opacity below {:.2g}{}; the training has perhaps just reset opacities, or the "
        "file "
        "holds haze: export a later step, or --opacity-threshold {:.2g} takes what is more opaque",
        opacity, seen, opacity);
  }
  if (fault.empty()) return "";
  return fmt::format(
      "a view is {}; a --crop leaves out what is between the camera and the object, and --up turns the scene", fault);
}

}  // namespace physmas::bundle
