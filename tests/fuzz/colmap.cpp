// COLMAP models. Input: 'b' for binary or anything else for text, two bytes with the length of the cameras file (little
// endian), the cameras file, the images file.
#include <algorithm>

#include "bundle/captured_views.h"
#include "guard.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 3) return 0;
  const std::string rest(reinterpret_cast<const char*>(data + 3), size - 3);
  const size_t cut = std::min<size_t>(data[1] | data[2] << 8, rest.size());
  physmas::guard([&] {
    physmas::bundle::views_from_colmap({"cameras", "images", rest.substr(0, cut), rest.substr(cut), data[0] == 'b'});
  });
  return 0;
}
