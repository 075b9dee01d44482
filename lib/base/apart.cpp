#include "base/apart.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <new>

#include "base/error.h"

namespace physmas {
namespace {

// The copy tells how it ended by its exit code: an ExitCode with the message in the pipe, or one of these.
constexpr int kReturned = 0;
constexpr int kOutOfMemory = 100;
constexpr int kOtherException = 101;

void write_all(int fd, const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const ssize_t n = ::write(fd, text.data() + at, text.size() - at);
    if (n < 0 && errno != EINTR) return;
    if (n > 0) at += static_cast<size_t>(n);
  }
}

std::string read_all(int fd) {
  std::string text;
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(buffer, static_cast<size_t>(n));
  }
}

[[noreturn]] void work_and_exit(const std::function<void()>& work, int seconds, int pipe) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU})
    ::signal(signal, SIG_DFL);
  std::set_new_handler(nullptr);
  const struct rlimit time = {static_cast<rlim_t>(seconds), static_cast<rlim_t>(seconds) + 1}, no_core = {0, 0};
  ::setrlimit(RLIMIT_CPU, &time);
  ::setrlimit(RLIMIT_CORE, &no_core);
  // What the C library or a sanitizer says about a crash is not for the user: the caller says it in one line.
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) nowhere >= 0 ? ::dup2(nowhere, fd) : ::close(fd);
  int code = kReturned;
  try {
    work();
  } catch (const Error& error) {
    write_all(pipe, error.what());
    code = static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    code = kOutOfMemory;
  } catch (const std::exception& exception) {
    write_all(pipe, exception.what());
    code = kOtherException;
  }
  ::_exit(code);
}

}  // namespace

Ending run_apart(const std::function<void()>& work, int seconds) {
  Ending ending;
  int ends[2];
  const bool piped = ::pipe2(ends, O_CLOEXEC) == 0;
  const pid_t child = piped ? ::fork() : -1;
  if (child < 0) {
    if (piped) ::close(ends[0]), ::close(ends[1]);
    work();
    ending.done = true;
    return ending;
  }
  if (child == 0) {
    ::close(ends[0]);
    work_and_exit(work, seconds, ends[1]);
  }
  ::close(ends[1]);
  const std::string message = read_all(ends[0]);
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw internal_error("a process of ours is gone");
  }
  if (WIFSIGNALED(status)) {
    ending.signal = WTERMSIG(status);
    ending.too_long = ending.signal == SIGXCPU;
    return ending;
  }
  const int code = WEXITSTATUS(status);
  if (code == kOutOfMemory) throw std::bad_alloc();
  if (code == kOtherException) throw internal_error(message);
  if (code != kReturned) throw Error(static_cast<ExitCode>(code), message);
  ending.done = true;
  return ending;
}

}  // namespace physmas
