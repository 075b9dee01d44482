#include "base/foreign_lines.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>

namespace physmas {
namespace {

std::mutex g_mutex;
std::atomic<int> g_standard_error{STDERR_FILENO};

}  // namespace

ForeignLines::ForeignLines() : lock_(g_mutex) {
  const int before = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (before < 0) return;
  kept_ = ::memfd_create("lines", MFD_CLOEXEC);
  g_standard_error = before;
  if (kept_ >= 0) ::dup2(kept_, STDERR_FILENO);
}

ForeignLines::~ForeignLines() {
  take();
}

std::string ForeignLines::take() {
  if (!lock_.owns_lock()) return "";
  std::string text;
  const int before = g_standard_error.exchange(STDERR_FILENO);
  if (before != STDERR_FILENO) {
    ::dup2(before, STDERR_FILENO);
    ::close(before);
  }
  if (kept_ >= 0) {
    char buffer[4096];
    const ssize_t size = ::pread(kept_, buffer, sizeof buffer, 0);
    if (size > 0) text.assign(buffer, static_cast<size_t>(size));
    ::close(kept_);
    kept_ = -1;
  }
  lock_.unlock();
  return text;
}

int standard_error() {
  return g_standard_error;
}

}  // namespace physmas
