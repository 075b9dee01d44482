#include "base/half_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <limits.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <regex>
#include <set>

#include "base/hash.h"

namespace physmas {
namespace {

// A signal handler may take neither memory nor locks, so the names lie here.
constexpr int kSlots = 16;
constexpr size_t kMostBytes = 4096;
enum SlotState { kFree = 0, kFilling, kInUse };
std::atomic<int> g_state[kSlots];
char g_path[kSlots][kMostBytes];

extern "C" void end_by_signal(int signal) {
  remove_half_files();
  // The handler is gone (SA_RESETHAND): this one ends the process.
  ::raise(signal);
}

bool watch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before;
    if (sigaction(signal, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) continue;
    struct sigaction action = {};
    action.sa_handler = end_by_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(signal, &action, nullptr);
  }
  return true;
}

std::string link_target(const char* path) {
  char target[256];
  const ssize_t size = ::readlink(path, target, sizeof target);
  return size > 0 ? std::string(target, static_cast<size_t>(size)) : "";
}

std::string host_digits() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  return sha256_text(std::string(name) + " " + link_target("/proc/self/ns/pid")).substr(0, 8);
}

// In ticks since boot; 0 where the system does not say, or there is no such process.
unsigned long long start_of(long pid) {
  char path[64], text[1024];
  std::snprintf(path, sizeof path, "/proc/%ld/stat", pid);
  const int fd = ::open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return 0;
  const ssize_t size = ::read(fd, text, sizeof text - 1);
  ::close(fd);
  if (size <= 0) return 0;
  text[size] = '\0';
  // Field 22; the second one, a name in parentheses, may hold spaces.
  const char* at = std::strrchr(text, ')');
  for (int field = 2; at != nullptr && field < 22; ++field) at = std::strchr(at + 1, ' ');
  return at != nullptr ? std::strtoull(at, nullptr, 10) : 0;
}

bool is_gone(long pid, unsigned long long start) {
  if (::kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH) return true;
  const unsigned long long now = start_of(pid);
  return now != 0 && start != 0 && now != start;
}

struct Owner {
  long pid = 0;
  unsigned long long start = 0;
  std::string host;
};

// Who writes a file of this name; pid 0 where the name is no half file's.
Owner owner_of(const std::string& name) {
  static const std::regex pattern(R"(^\..*\.(\d{1,9})\.(\d{1,18})\.([0-9a-f]{8})\.tmp(\.[a-z0-9]+)?$)");
  std::smatch parts;
  if (name.size() > NAME_MAX || !std::regex_match(name, parts, pattern)) return {};
  return {std::stol(parts[1]), std::stoull(parts[2]), parts[3]};
}

}  // namespace

std::string half_file_name(const std::string& name, const std::string& suffix) {
  static const std::string host = host_digits();
  // Not kept from before a fork.
  const std::string owner = fmt::format(".{}.{}.{}.tmp", ::getpid(), start_of(::getpid()), host) + suffix;
  // A file whose name is as long as it may be has a shorter one until it is whole.
  const size_t room = NAME_MAX - 1 - owner.size();
  const std::string stem =
      name.size() <= room ? name : name.substr(0, room - 17) + "." + sha256_text(name).substr(0, 16);
  return "." + stem + owner;
}

void remove_stale_half_files(const std::string& folder) {
  static std::mutex mutex;
  static std::set<std::string> looked_at;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!looked_at.insert(folder).second) return;
  }
  static const std::string host = host_digits();
  std::error_code failure;
  for (std::filesystem::directory_iterator at(folder, failure), end; !failure && at != end; at.increment(failure)) {
    const Owner owner = owner_of(at->path().filename().string());
    if (owner.pid > 0 && owner.host == host && is_gone(owner.pid, owner.start)) ::unlink(at->path().c_str());
  }
}

void remove_half_files() {
  for (int i = 0; i < kSlots; ++i) {
    if (g_state[i].load() == kInUse) ::unlink(g_path[i]);
  }
}

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
