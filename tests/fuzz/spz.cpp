// The inside of .spz files: what the input is compressed to always inflates, so the fuzzer reaches the values.
#include "guard.h"
#include "scene/gaussian_files.h"
#include "unit/scene/spz_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes = physmas::testing::gzip(std::string(reinterpret_cast<const char*>(data), size));
  physmas::guard([&] { physmas::parse_gaussians("input.spz", bytes); });
  return 0;
}
