// .spz files: as they are, and their inside, which is packed here so that it always unpacks and the fuzzer reaches the
// values: within gzip, and as the streams of version 4, of which everything after the arrays is extension records.
#include "guard.h"
#include "scene/gaussian_files.h"
#include "unit/scene/spz_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  guard([&] { parse_gaussian_file("input.spz", bytes); });
  guard([&] { parse_gaussian_file("input.spz", testing::gzip(bytes)); });
  if (size < 16) return 0;
  uint64_t count = 0;
  for (int k = 0; k < 4; ++k) count |= static_cast<uint64_t>(data[8 + k]) << 8 * k;
  const uint64_t each = 20 + 3 * (uint64_t{data[12]} + 1) * (uint64_t{data[12]} + 1) - 3;
  if (count > (size - 16) / each) return 0;
  const size_t end = 16 + static_cast<size_t>(count * each);
  guard([&] { parse_gaussian_file("input.spz", testing::spz4(bytes.substr(0, end), data[14], bytes.substr(end))); });
  return 0;
}
