// Arrays of numpy and JSON: one .npy by its signature, everything else as a .npz or JSON of two arrays.
#include "eval/array_file.h"
#include "guard.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    if (size > 0 && data[0] == 0x93) {
      physmas::eval::parse_npy(bytes, "input.npy", "tracks");
    } else {
      physmas::eval::parse_arrays(bytes, "input.npz", {"tracks", "visibility"});
    }
  });
  return 0;
}
