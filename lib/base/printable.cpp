#include "base/printable.h"

#include <algorithm>

namespace physmas {
namespace {

// Of a character that is whole.
unsigned code_point(const std::string& text, size_t at, size_t bytes) {
  const auto byte = [&](size_t i) -> unsigned { return static_cast<unsigned char>(text[at + i]); };
  if (bytes == 1) return byte(0);
  unsigned code = byte(0) & (0xffu >> (bytes + 1));
  for (size_t i = 1; i < bytes; ++i) code = code << 6 | (byte(i) & 0x3f);
  return code;
}

}  // namespace

size_t character_bytes(const std::string& text, size_t at) {
  const auto byte = [&](size_t i) -> unsigned { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0; };
  const unsigned first = byte(at), second = byte(at + 1);
  const size_t length = first < 0x80   ? 1
                        : first < 0xc2 ? 0
                        : first < 0xe0 ? 2
                        : first < 0xf0 ? 3
                        : first < 0xf5 ? 4
                                       : 0;
  for (size_t i = at + 1; i < at + length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  // Longer than need be, halves of surrogate pairs, beyond the last character.
  const bool forbidden = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                         (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return forbidden ? 0 : length;
}

bool is_control(const std::string& text, size_t at, size_t bytes) {
  const unsigned code = code_point(text, at, bytes);
  const auto within = [&](unsigned first, unsigned last) { return code >= first && code <= last; };
  return code < 0x20 || within(0x7f, 0x9f) ||
         // Marks, embeddings, overrides and isolates of the writing direction; separators of lines and paragraphs.
         code == 0x061c || within(0x200e, 0x200f) || within(0x2028, 0x202e) || within(0x2066, 0x2069) ||
         // A byte order mark, which is invisible, and tags, which hide text.
         code == 0xfeff || within(0xe0000, 0xe007f);
}

std::string printable(const std::string& text) {
  std::string clean;
  clean.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    const size_t bytes = character_bytes(text, at);
    const bool kept = bytes > 0 && (text[at] == '\n' || text[at] == '\t' || !is_control(text, at, bytes));
    kept ? clean.append(text, at, bytes) : clean.append(1, '?');
    at += std::max<size_t>(bytes, 1);
  }
  return clean;
}

}  // namespace physmas
