#include "base/error.h"

#include <algorithm>
#include <cstring>

#include "base/printable.h"

namespace physmas {
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
    const bool ascii_control = static_cast<unsigned char>(text[at]) < 0x20 || text[at] == 0x7f;
    if (bytes == 0 || (!ascii_control && is_control(text, at, bytes))) {
      line += '?';
    } else if (!ascii_control) {
      line.append(text, at, bytes);
    } else if (line.empty() || line.back() != ' ') {
      line += ' ';
    }
    at += std::max<size_t>(bytes, 1);
  }
  return line;
}

}  // namespace physmas
