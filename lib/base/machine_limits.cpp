#include "base/machine_limits.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "base/foreign_lines.h"
#include "base/half_files.h"

namespace physmas {
namespace {

constexpr const char* kNoMemory =
    "out of memory; use fewer --threads, fewer particles, a smaller grid or smaller images";
constexpr const char* kNoThread =
    "a thread cannot be started: the machine's limit is reached; use fewer with --threads 1";

bool g_watching = false;

// Without memory of its own.
[[noreturn]] void end_suddenly(const char* text, ExitCode code) {
  remove_half_files();
  char line[2200];
  const int size = std::snprintf(line, sizeof line, "%s: error: %s\n", program_invocation_short_name, text);
  const size_t bytes = size < 0                                  ? 0
                       : static_cast<size_t>(size) < sizeof line ? static_cast<size_t>(size)
                                                                 : sizeof line - 1;
  // One line, whatever the text.
  for (size_t i = 0; i + 1 < bytes; ++i) {
    if (static_cast<unsigned char>(line[i]) < 0x20) line[i] = ' ';
  }
  if (::write(standard_error(), line, bytes) < 0) ::_exit(static_cast<int>(code));
  ::_exit(static_cast<int>(code));
}

// An exception that nothing catches.
[[noreturn]] void end_by_exception() {
  try {
    if (std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const Error& error) {
    end_suddenly(error.what(), error.code());
  } catch (const std::exception& exception) {
    if (const std::optional<Error> limit = limit_behind(exception)) end_suddenly(limit->what(), limit->code());
    char text[2000];
    std::snprintf(text, sizeof text, "internal fault: %s", exception.what());
    end_suddenly(text, ExitCode::internal);
  } catch (...) {
  }
  end_suddenly("internal fault: an unknown exception", ExitCode::internal);
}

// Memory that neither new nor a library that uses it got.
[[noreturn]] void end_without_memory() {
  end_suddenly(kNoMemory, ExitCode::invalid_input);
}

// Libraries that do not look whether they got memory, and faults of ours.
void end_by_fault(int signal) {
  char text[200];
  std::snprintf(text, sizeof text, "internal fault: %s; it may be that memory ran out: use fewer --threads",
                sigdescr_np(signal));
  end_suddenly(text, ExitCode::internal);
}

// OpenMP's runtime has said in a line of its own what it lacks: a thread or memory.
void end_by_exit() {
  if (g_watching)
    end_suddenly("too few threads or too little memory; use fewer with --threads 1", ExitCode::invalid_input);
}

}  // namespace

Error out_of_memory() {
  return Error(ExitCode::invalid_input, kNoMemory);
}

Error no_thread() {
  return Error(ExitCode::invalid_input, kNoThread);
}

std::optional<Error> limit_behind(const std::exception& exception) {
  const auto* from_system = dynamic_cast<const std::system_error*>(&exception);
  if (from_system != nullptr && from_system->code() == std::errc::resource_unavailable_try_again) return no_thread();
  if (dynamic_cast<const std::bad_alloc*>(&exception) != nullptr) return out_of_memory();
  // OpenCV and its threads (TBB) have no better way to say it than their texts.
  if (std::strstr(exception.what(), "pthread_create") != nullptr) return no_thread();
  if (std::strstr(exception.what(), "Insufficient memory") != nullptr) return out_of_memory();
  return std::nullopt;
}

void require_threads(int threads) {
  std::mutex mutex;
  std::condition_variable wake;
  bool over = false;
  std::vector<std::thread> started;
  bool all = true;
  try {
    started.reserve(static_cast<size_t>(threads));
    for (int i = 1; i < threads; ++i) {
      started.emplace_back([&] {
        std::unique_lock<std::mutex> lock(mutex);
        wake.wait(lock, [&] { return over; });
      });
    }
  } catch (const std::system_error&) {
    all = false;
  } catch (const std::bad_alloc&) {
    all = false;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex);
    over = true;
  }
  wake.notify_all();
  for (std::thread& thread : started) thread.join();
  if (!all) throw no_thread();
}

bool report_sudden_ends() {
  std::set_terminate(end_by_exception);
  std::set_new_handler(end_without_memory);
#ifndef __SANITIZE_ADDRESS__
  // On a stack of its own, for when the usual one is full.
  alignas(16) static char stack[64 << 10];
  stack_t other = {};
  other.ss_sp = stack;
  other.ss_size = sizeof stack;
  struct sigaction action = {};
  action.sa_handler = end_by_fault;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | (sigaltstack(&other, nullptr) == 0 ? SA_ONSTACK : 0);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(signal, &action, nullptr);
#endif
  return true;
}

ForeignExits::ForeignExits() {
  static const bool registered = std::atexit(end_by_exit) == 0;
  g_watching = registered;
}

ForeignExits::~ForeignExits() {
  g_watching = false;
}

}  // namespace physmas
