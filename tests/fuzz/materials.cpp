// Material fields of other programs: .npz by its signature, USD text, everything else as what is named and refused.
#include "bundle/material_files.h"
#include "guard.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  guard([&] {
    const bundle::MaterialSamples samples = bundle::parse_material_samples(bytes, "input.npz");
    bundle::placed_samples(samples, {1, 2, 3}, Eigen::Matrix3d::Identity());
  });
  return 0;
}
