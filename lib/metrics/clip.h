// CLIP similarity (paper, Eq. supp-clipsim) and what its encoders take (Radford et al. 2021).
#ifndef PHYSMAS_METRICS_CLIP_H
#define PHYSMAS_METRICS_CLIP_H

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "metrics/motion.h"
#include "records/array_file.h"
#include "scene/image.h"

namespace physmas::metrics {

// Embeddings of one case: D numbers each, of the text and of every frame.
struct ClipEmbeddings {
  std::vector<double> text;
  std::vector<std::vector<double>> frames;  // [T]
};

// `text` [D] or [1, D] and `frames` [T, D] from a .npz or JSON file. Errors: exit code 3.
ClipEmbeddings load_clip_embeddings(const std::string& path);
// The same from arrays of these names; `file` is only named in messages.
ClipEmbeddings clip_embeddings_from(const std::map<std::string, Array>& arrays, const std::string& file);

// Mean cosine over the frames, not scaled. Invalid without frames, or when an embedding has no direction (zero or not
// finite): that frame is not left out.
Measurement clip_similarity(const ClipEmbeddings& embeddings);

constexpr int kClipSize = 224;    // pixels
constexpr int kClipContext = 77;  // tokens

// RGB to [3, 224, 224]: shortest side to 224 by bicubic resampling (that of Pillow: antialiased, a = -0.5, 8 bits after
// each pass), centre crop, scaled to 0..1, normalised per channel with CLIP's mean and deviation.
// Sides of more than 16 to 1 are an Error (exit code 3).
std::vector<float> clip_pixels(const Image& frame);

// CLIP's byte-pair encoding. The merges are a file of the user's (bpe_simple_vocab_16e6.txt, unpacked).
class ClipTokenizer {
 public:
  // merges: a first line that is skipped, then a pair per line; CLIP uses the first 48,894 of them. file: for messages.
  // Errors: exit code 3.
  ClipTokenizer(const std::string& merges, const std::string& file);
  // [77] start, tokens, end, zeros. Errors (exit code 3): a prompt of more than 75 tokens; a character that is not
  // ASCII, for which CLIP's own cleaning would be needed.
  std::vector<int64_t> encode(const std::string& prompt) const;

 private:
  std::vector<std::string> split_word(const std::string& word) const;

  std::map<std::pair<std::string, std::string>, int> rank_;
  std::map<std::string, int64_t> id_;
};

ClipTokenizer load_clip_tokenizer(const std::string& path);

}  // namespace physmas::metrics

#endif
