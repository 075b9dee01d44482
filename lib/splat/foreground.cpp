#include "splat/foreground.h"

#include <algorithm>

namespace physmas::splat {

FrameForeground measure_foreground(const RenderedImage& image, const Image& quantized, int frame,
                                   double dark_luminance) {
  FrameForeground result;
  result.frame = frame;
  int x0 = image.width, y0 = image.height, x1 = 0, y1 = 0;
  long foreground = 0, dark = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.alpha[static_cast<size_t>(y) * image.width + x] < kForegroundAlpha) continue;
      ++foreground;
      const uint8_t* rgb = quantized.at(x, y);
      if ((0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255 < dark_luminance) ++dark;
      x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
      y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    }
  }
  result.present = foreground > 0;
  if (!result.present) return result;
  result.x0 = x0, result.y0 = y0, result.x1 = x1, result.y1 = y1;
  result.dark_ratio = static_cast<double>(dark) / static_cast<double>(foreground);
  return result;
}

}  // namespace physmas::splat
