// mp4 videos, every frame as RGB.
#include "splat/video.h"

#include "guard.h"
#include "scratch.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const physmas::Scratch scratch;
  const std::string path = scratch.write("input.mp4", std::string(reinterpret_cast<const char*>(data), size));
  physmas::guard([&] {
    physmas::splat::VideoReader reader(path);
    physmas::Image frame;
    for (int t = 0; t < 16 && reader.next(&frame); ++t) {
    }
  });
  return 0;
}
