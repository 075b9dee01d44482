#include "base/error.h"

#include <algorithm>
#include <cstring>

namespace physmas {
namespace {

// Length of the UTF-8 character that begins there; 0 where none does.
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

}  // namespace

Error invalid_input(const Finding& f) {
  std::string text = f.file;
  if (!f.field.empty()) text += (text.empty() ? "" : ": ") + f.field;
  if (!f.found.empty()) text += ": found " + f.found;
  if (!f.expected.empty()) text += std::string(f.found.empty() ? ": " : ", ") + "expected " + f.expected;
  if (!f.fix.empty()) text += "; " + f.fix;
  return Error(ExitCode::invalid_input, one_line(text, 1000));
}

Error internal_error(const std::string& message) {
  return Error(ExitCode::internal, one_line("internal fault: " + message));
}

Error system_error(const std::string& file, const std::string& doing, int error_number) {
  return Error(ExitCode::invalid_input, one_line(file + ": " + doing + ": " + std::strerror(error_number)));
}

long utf8_length(const std::string& text) {
  long count = 0;
  for (size_t i = 0; i < text.size(); ++count) {
    const size_t bytes = character_bytes(text, i);
    if (bytes == 0) return -1;
    i += bytes;
  }
  return count;
}

std::string one_line(const std::string& text, size_t limit) {
  std::string line;
  for (size_t at = 0; at < text.size();) {
    if (line.size() >= limit) return line + "...";
    const size_t bytes = character_bytes(text, at);
    const bool control = static_cast<unsigned char>(text[at]) < 0x20 || text[at] == 0x7f;
    if (bytes == 0) {
      line += '?';
    } else if (!control) {
      line.append(text, at, bytes);
    } else if (line.empty() || line.back() != ' ') {
      line += ' ';
    }
    at += std::max<size_t>(bytes, 1);
  }
  return line;
}

}  // namespace physmas
