// Arrays of numpy and JSON: one .npy by its signature, everything else as a .npz or JSON of two arrays, as tracks and
// as CLIP's embeddings.
#include "guard.h"
#include "metrics/clip.h"
#include "metrics/video_tracks.h"
#include "records/array_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size > 0 && data[0] == 0x93) {
    guard([&] { parse_npy(bytes, "input.npy", "tracks"); });
    return 0;
  }
  guard([&] { metrics::tracks_from(parse_arrays(bytes, "input.npz", {"tracks", "visibility"}), "input.npz", 8, 4); });
  guard([&] {
    metrics::clip_similarity(
        metrics::clip_embeddings_from(parse_arrays(bytes, "input.npz", {"text", "frames"}), "input.npz"));
  });
  return 0;
}
