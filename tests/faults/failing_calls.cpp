// A library for LD_PRELOAD that lets one call of the C library fail, so that tests see what a tool makes of it.
//
//   PM_FAULT        which: open, write, short (writes half), sync, rename, close, truncate, map, memory or thread
//   PM_FAULT_AT     the how manieth of them fails, from 1; 0: none
//   PM_FAULT_ERROR  the number of the error (errno); EIO without it
//   PM_FAULT_STAYS  not empty: all that follow fail, too, as on a full disk
//   PM_FAULT_UNDER  only files of this folder count, and relative paths
//   PM_FAULT_COUNT  a file that gets the number of calls when the process ends by exit
//
// Counting begins with main(): what the libraries do before is not the tool's. In a copy of the process (fork) it goes
// on from where it was.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>

extern "C" {
// The C library's own, which need no dlsym: that takes memory itself.
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

struct Plan {
  char kind[16] = "";
  long at = 0;
  int error = EIO;
  bool stays = false;
  char under[2048] = "";
  char count_file[2048] = "";
};

Plan g_plan;
std::atomic<bool> g_ready{false};
std::atomic<long> g_calls{0};

void copy_variable(const char* name, char* to, size_t size) {
  const char* value = getenv(name);
  snprintf(to, size, "%s", value == nullptr ? "" : value);
}

__attribute__((constructor)) void read_plan() {
  copy_variable("PM_FAULT", g_plan.kind, sizeof g_plan.kind);
  copy_variable("PM_FAULT_UNDER", g_plan.under, sizeof g_plan.under);
  copy_variable("PM_FAULT_COUNT", g_plan.count_file, sizeof g_plan.count_file);
  if (const char* at = getenv("PM_FAULT_AT")) g_plan.at = atol(at);
  if (const char* error = getenv("PM_FAULT_ERROR")) g_plan.error = atoi(error);
  const char* stays = getenv("PM_FAULT_STAYS");
  g_plan.stays = stays != nullptr && *stays != '\0';
}

using Main = int (*)(int, char**, char**);
Main g_main = nullptr;

int main_and_count(int count, char** arguments, char** environment) {
  g_ready = true;
  return g_main(count, arguments, environment);
}

__attribute__((destructor)) void write_count() {
  const long calls = g_calls;
  g_ready = false;
  if (*g_plan.count_file == '\0') return;
  if (FILE* file = fopen(g_plan.count_file, "w")) {
    fprintf(file, "%ld\n", calls);
    fclose(file);
  }
}

template <class Function>
Function real(Function, const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
#define REAL(name) real(&name, #name)

bool is(const char* kind) {
  return g_ready && strcmp(g_plan.kind, kind) == 0;
}

// Counts a call of that kind; whether it is to fail.
bool fails(const char* kind) {
  if (!is(kind)) return false;
  const long call = ++g_calls;
  const bool now = g_plan.at > 0 && (call == g_plan.at || (g_plan.stays && call > g_plan.at));
  if (now) errno = g_plan.error;
  return now;
}

bool counts(const char* path) {
  return path != nullptr && (path[0] != '/' || strncmp(path, g_plan.under, strlen(g_plan.under)) == 0);
}

bool counts(int fd) {
  if (fd <= STDERR_FILENO) return false;
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  if (size <= 0) return false;
  path[size] = '\0';
  return path[0] == '/' && counts(path);
}

bool open_fails(const char* path) {
  return is("open") && counts(path) && fails("open");
}

// How much of a write is done: all of it, half, or -1 where it fails.
ssize_t part(int fd, size_t size) {
  const ssize_t all = static_cast<ssize_t>(size);
  if (is("write") && counts(fd) && fails("write")) return -1;
  if (is("short") && size > 1 && counts(fd) && fails("short")) return all / 2;
  return all;
}

}  // namespace

extern "C" {

int __libc_start_main(Main main, int count, char** arguments, void (*before)(), void (*after)(), void (*at_end)(),
                      void* stack) {
  using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  g_main = main;
  return reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"))(main_and_count, count, arguments, before, after,
                                                                        at_end, stack);
}

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  return open_fails(path) ? -1 : REAL(open)(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = va_arg(list, mode_t);
  va_end(list);
  return open_fails(path) ? -1 : REAL(open64)(path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) {
  return open_fails(path) ? nullptr : REAL(fopen)(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  return open_fails(path) ? nullptr : REAL(fopen64)(path, mode);
}

ssize_t write(int fd, const void* data, size_t size) {
  const ssize_t done = part(fd, size);
  return done < 0 ? -1 : REAL(write)(fd, data, static_cast<size_t>(done));
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
  const ssize_t done = part(fd, size);
  return done < 0 ? -1 : REAL(pwrite)(fd, data, static_cast<size_t>(done), at);
}

ssize_t pwrite64(int fd, const void* data, size_t size, off64_t at) {
  const ssize_t done = part(fd, size);
  return done < 0 ? -1 : REAL(pwrite64)(fd, data, static_cast<size_t>(done), at);
}

ssize_t writev(int fd, const struct iovec* parts, int count) {
  return is("write") && counts(fd) && fails("write") ? -1 : REAL(writev)(fd, parts, count);
}

ssize_t sendfile(int out, int in, off_t* at, size_t size) {
  const ssize_t done = part(out, size);
  return done < 0 ? -1 : REAL(sendfile)(out, in, at, static_cast<size_t>(done));
}

ssize_t sendfile64(int out, int in, off64_t* at, size_t size) {
  const ssize_t done = part(out, size);
  return done < 0 ? -1 : REAL(sendfile64)(out, in, at, static_cast<size_t>(done));
}

int fsync(int fd) {
  return is("sync") && counts(fd) && fails("sync") ? -1 : REAL(fsync)(fd);
}

int rename(const char* from, const char* to) noexcept {
  return is("rename") && counts(from) && fails("rename") ? -1 : REAL(rename)(from, to);
}

int ftruncate(int fd, off_t size) noexcept {
  return is("truncate") && counts(fd) && fails("truncate") ? -1 : REAL(ftruncate)(fd, size);
}

int ftruncate64(int fd, off64_t size) noexcept {
  return is("truncate") && counts(fd) && fails("truncate") ? -1 : REAL(ftruncate64)(fd, size);
}

// The file is closed all the same, as Linux does it.
int close(int fd) {
  const bool failed = is("close") && counts(fd) && fails("close");
  const int closed = REAL(close)(fd);
  if (!failed) return closed;
  errno = g_plan.error;
  return -1;
}

void* mmap(void* address, size_t size, int protection, int flags, int fd, off_t at) noexcept {
  return fails("map") ? MAP_FAILED : REAL(mmap)(address, size, protection, flags, fd, at);
}

void* mmap64(void* address, size_t size, int protection, int flags, int fd, off64_t at) noexcept {
  return fails("map") ? MAP_FAILED : REAL(mmap64)(address, size, protection, flags, fd, at);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  return fails("thread") ? EAGAIN : REAL(pthread_create)(thread, attributes, start, argument);
}

void* malloc(size_t size) noexcept {
  return fails("memory") ? nullptr : __libc_malloc(size);
}

void* calloc(size_t count, size_t size) noexcept {
  return fails("memory") ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* old, size_t size) noexcept {
  return fails("memory") ? nullptr : __libc_realloc(old, size);
}

void* memalign(size_t alignment, size_t size) noexcept {
  return fails("memory") ? nullptr : __libc_memalign(alignment, size);
}

void* aligned_alloc(size_t alignment, size_t size) noexcept {
  return fails("memory") ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** out, size_t alignment, size_t size) noexcept {
  void* memory = fails("memory") ? nullptr : __libc_memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *out = memory;
  return 0;
}

}  // extern "C"
