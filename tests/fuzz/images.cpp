// Pictures: PNG and JPEG. The checksums of a PNG's chunks are put right first, so that the fuzzer reaches what is
// behind them.
#include <zlib.h>

#include "guard.h"
#include "scene/image_file.h"

namespace {

void fix_checksums(std::string& png) {
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<uint8_t>(png[i]);
    return value;
  };
  for (size_t at = 8; at + 12 <= png.size();) {
    const size_t length = number(at);
    if (length > png.size() - at - 12) return;
    const uLong sum = crc32(0, reinterpret_cast<const Bytef*>(&png[at + 4]), static_cast<uInt>(length + 4));
    for (int i = 0; i < 4; ++i) png[at + 8 + length + i] = static_cast<char>(sum >> (24 - 8 * i));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.compare(0, 4, "\x89PNG") == 0) fix_checksums(bytes);
  physmas::guard([&] { physmas::decode_image(bytes, "input.png"); });
  return 0;
}
