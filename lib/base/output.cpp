#include "base/output.h"

#include <cerrno>
#include <cstdio>

#include "base/error.h"
#include "base/printable.h"

namespace physmas {

void print_text(const std::string& text) {
  const std::string clean = printable(text);
  errno = 0;
  const bool written = std::fwrite(clean.data(), 1, clean.size(), stdout) == clean.size() && std::fflush(stdout) == 0;
  if (!written && errno != EPIPE) throw system_error("standard output", "cannot be written", errno);
}

}  // namespace physmas
