#include "splat/quantize.h"

#include <algorithm>

namespace physmas::splat {
namespace {

uint8_t level(float value) {
  return static_cast<uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f);
}

}  // namespace

Image quantize(const RenderedImage& image) {
  Image out(image.width, image.height, 3);
  for (size_t i = 0; i < out.pixels.size(); ++i) out.pixels[i] = level(image.rgb[i]);
  return out;
}

Image quantize_with_alpha(const RenderedImage& image) {
  Image out(image.width, image.height, 4);
  for (size_t p = 0; p < image.alpha.size(); ++p) {
    const float alpha = image.alpha[p];
    for (int k = 0; k < 3; ++k) out.pixels[4 * p + k] = alpha > 0 ? level(image.rgb[3 * p + k] / alpha) : 0;
    out.pixels[4 * p + 3] = level(alpha);
  }
  return out;
}

}  // namespace physmas::splat
