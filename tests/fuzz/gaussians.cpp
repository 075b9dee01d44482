// Files of Gaussians: PLY, compressed PLY and .spz by their first bytes, everything else as .splat.
#include "bundle/selection.h"
#include "guard.h"
#include "scene/gaussian_files.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    const physmas::Gaussians gaussians = physmas::parse_gaussians("input.splat", bytes);
    physmas::bundle::find_floaters(gaussians);
  });
  return 0;
}
