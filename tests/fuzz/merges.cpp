// CLIP's table of merges, and prompts in its tokens. Input: a byte with the length of the prompt, the prompt, the
// table.
#include <algorithm>

#include "guard.h"
#include "metrics/clip.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const std::string rest(reinterpret_cast<const char*>(data + 1), size - 1);
  const size_t cut = std::min<size_t>(data[0], rest.size());
  physmas::guard([&] { physmas::metrics::ClipTokenizer(rest.substr(cut), "input.txt").encode(rest.substr(0, cut)); });
  return 0;
}
