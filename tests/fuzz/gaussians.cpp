// Files of Gaussians: PLY, compressed PLY, .spz, .sog and gzip by their first bytes, everything else as .splat.
#include "bundle/dense_component.h"
#include "bundle/selection.h"
#include "guard.h"
#include "scene/gaussian_files.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    const physmas::GaussianFile file = physmas::parse_gaussian_file("input.splat", bytes);
    physmas::bundle::find_floaters(file.gaussians);
    physmas::bundle::dense_component(file.gaussians);
  });
  return 0;
}
