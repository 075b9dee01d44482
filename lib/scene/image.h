// 8-bit images.
#ifndef PHYSMAS_SCENE_IMAGE_H
#define PHYSMAS_SCENE_IMAGE_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace physmas {

// Row-major, channels interleaved in the order R, G, B, A; alpha is straight (not premultiplied).
struct Image {
  int width = 0, height = 0;    // pixels
  int channels = 3;             // 1 grey, 3 RGB, 4 RGBA
  std::vector<uint8_t> pixels;  // [H * W * channels]

  Image() = default;
  Image(int w, int h, int c) : width(w), height(h), channels(c), pixels(size_t(w) * h * c, 0) {}
  uint8_t* at(int x, int y) { return &pixels[(size_t(y) * width + x) * channels]; }
  const uint8_t* at(int x, int y) const { return &pixels[(size_t(y) * width + x) * channels]; }
};

}  // namespace physmas

#endif
