// Comparing rendered images in the renderer's tests.
#ifndef PHYSMAS_TESTS_SPLAT_CHECKS_H
#define PHYSMAS_TESTS_SPLAT_CHECKS_H

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "splat/renderer.h"
#include "unit/splat/reference.h"

namespace physmas::splat_test {

using splat::RenderedImage;

// Largest difference from the reference in 8-bit levels over the pixels that no threshold tie explains, after cutting
// to what 8 bits show; checks that few pixels are excused.
inline double levels_off(const RenderedImage& image, const ReferenceImage& reference) {
  double worst = 0;
  size_t excused = 0;
  for (size_t p = 0; p < reference.alpha.size(); ++p) {
    if (reference.tie[p]) {
      ++excused;
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const double a = std::clamp<double>(image.rgb[3 * p + k], 0, 1),
                   b = std::clamp(reference.rgb[3 * p + k], 0.0, 1.0);
      worst = std::max(worst, 255 * std::abs(a - b));
    }
    worst = std::max(worst, 255 * std::abs(image.alpha[p] - reference.alpha[p]));
  }
  CHECK(excused < reference.alpha.size() / 10);
  return worst;
}

inline bool all_finite(const RenderedImage& image) {
  const auto finite = [](float v) { return std::isfinite(v); };
  return std::all_of(image.rgb.begin(), image.rgb.end(), finite) &&
         std::all_of(image.alpha.begin(), image.alpha.end(), finite) &&
         std::all_of(image.depth.begin(), image.depth.end(), finite);
}

inline bool same_pixels(const RenderedImage& a, const RenderedImage& b) {
  return a.rgb == b.rgb && a.alpha == b.alpha && a.depth == b.depth && a.label == b.label;
}

inline bool shows_background_only(const RenderedImage& image) {
  return std::all_of(image.alpha.begin(), image.alpha.end(), [](float a) { return a == 0; });
}

}  // namespace physmas::splat_test

#endif
