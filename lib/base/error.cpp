#include "base/error.h"

#include <cstring>

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

std::string one_line(const std::string& text, size_t limit) {
  std::string line;
  for (char c : text) {
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    if (control && !line.empty() && line.back() == ' ') continue;
    line += control ? ' ' : c;
    if (line.size() >= limit) return line + "...";
  }
  return line;
}

}  // namespace physmas
