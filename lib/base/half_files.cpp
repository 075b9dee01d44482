#include "base/half_files.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstring>

namespace physmas {
namespace {

// A signal handler may take neither memory nor locks, so the names lie here.
constexpr int kSlots = 16;
constexpr size_t kMostBytes = 4096;
enum SlotState { kFree = 0, kFilling, kInUse };
std::atomic<int> g_state[kSlots];
char g_path[kSlots][kMostBytes];

extern "C" void remove_half_files(int signal) {
  for (int i = 0; i < kSlots; ++i) {
    if (g_state[i].load() == kInUse) ::unlink(g_path[i]);
  }
  // The handler is gone (SA_RESETHAND): this one ends the process.
  ::raise(signal);
}

bool watch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before;
    if (sigaction(signal, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) continue;
    struct sigaction action = {};
    action.sa_handler = remove_half_files;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(signal, &action, nullptr);
  }
  return true;
}

}  // namespace

void remove_on_signal(const std::string& path) {
  [[maybe_unused]] static const bool watched = watch_signals();
  if (path.size() >= kMostBytes) return;
  for (int i = 0; i < kSlots; ++i) {
    int expected = kFree;
    if (!g_state[i].compare_exchange_strong(expected, kFilling)) continue;
    std::memcpy(g_path[i], path.c_str(), path.size() + 1);
    g_state[i].store(kInUse);
    return;
  }
}

void keep_on_signal(const std::string& path) {
  for (int i = 0; i < kSlots; ++i) {
    int expected = kInUse;
    if (g_state[i].load() != kInUse || path != g_path[i]) continue;
    if (g_state[i].compare_exchange_strong(expected, kFree)) return;
  }
}

}  // namespace physmas
