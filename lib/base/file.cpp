#include "base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/half_files.h"

namespace fs = std::filesystem;

namespace physmas {
namespace {

using File = std::unique_ptr<FILE, int (*)(FILE*)>;

// What a path leads to, where that is no regular file; empty where it is.
const char* other_kind(const struct stat& info) {
  if (S_ISREG(info.st_mode)) return "";
  if (S_ISDIR(info.st_mode)) return "a folder";
  if (S_ISFIFO(info.st_mode)) return "a pipe";
  if (S_ISSOCK(info.st_mode)) return "a socket";
  return "a device";
}

// Without links and dots, as far as the path exists; empty where a folder on the way may not be looked into. An error
// of the system (no memory) is an Error: it must not pass for another path.
fs::path canonical(const std::string& path) {
  std::error_code failure;
  // Absolute first: weakly_canonical leaves a relative path relative when its first folder does not exist yet.
  const fs::path absolute = fs::absolute(path, failure);
  const fs::path whole = failure ? fs::path() : fs::weakly_canonical(absolute, failure);
  if (!failure) return whole;
  if (failure == std::errc::permission_denied || failure == std::errc::no_such_file_or_directory) return {};
  throw system_error(path, "its place cannot be found", failure.value());
}

void require_regular(const std::string& path, const struct stat& info, const char* expected) {
  const char* kind = other_kind(info);
  if (*kind != '\0') throw invalid_input({path, "", kind, expected});
}

bool same_bytes(const std::string& a, const std::string& b) {
  struct stat sa, sb;
  if (stat(a.c_str(), &sa) != 0 || stat(b.c_str(), &sb) != 0) return false;
  if (!S_ISREG(sa.st_mode) || !S_ISREG(sb.st_mode) || sa.st_size != sb.st_size) return false;
  const File fa(std::fopen(a.c_str(), "rb"), std::fclose), fb(std::fopen(b.c_str(), "rb"), std::fclose);
  if (!fa || !fb) return false;
  std::string ba(1 << 20, '\0'), bb(1 << 20, '\0');
  for (;;) {
    const size_t na = std::fread(&ba[0], 1, ba.size(), fa.get());
    const size_t nb = std::fread(&bb[0], 1, bb.size(), fb.get());
    if (na != nb || ba.compare(0, na, bb, 0, nb) != 0) return false;
    if (na == 0) return std::ferror(fa.get()) == 0 && std::ferror(fb.get()) == 0;
  }
}

}  // namespace

uint64_t regular_file_size(const std::string& path) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) throw system_error(path, "cannot be read", errno);
  require_regular(path, info, "a file");
  return static_cast<uint64_t>(info.st_size);
}

int open_regular_file(const std::string& path) {
  // Looked at before as well: opening a device can have effects.
  regular_file_size(path);
  const int fd = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) throw system_error(path, "cannot be read", errno);
  struct stat info;
  if (fstat(fd, &info) == 0 && S_ISREG(info.st_mode)) return fd;
  ::close(fd);
  throw invalid_input({path, "", "something else than a moment before", "a file"});
}

std::string read_file(const std::string& path, size_t limit) {
  const uint64_t size = regular_file_size(path);
  const int fd = open_regular_file(path);
  const File file(::fdopen(fd, "rb"), std::fclose);
  if (!file) {
    ::close(fd);
    throw system_error(path, "cannot be read", ENOMEM);
  }
  std::string bytes;
  // Growing piece by piece would need twice the memory for a moment.
  bytes.reserve(std::min(static_cast<size_t>(size), limit));
  // A small file does not pay for a large buffer.
  std::string buffer(std::min(static_cast<size_t>(size) + 1, size_t{1} << 20), '\0');
  size_t n;
  while ((n = std::fread(&buffer[0], 1, buffer.size(), file.get())) > 0) {
    if (bytes.size() + n > limit) {
      throw invalid_input({path, "", "more than " + std::to_string(limit) + " bytes", "a smaller file"});
    }
    bytes.append(buffer, 0, n);
  }
  if (std::ferror(file.get()) != 0) throw system_error(path, "cannot be read", errno);
  return bytes;
}

AtomicFile::AtomicFile(const std::string& path, const std::string& suffix) : path_(path) {
  const fs::path folder = folder_of(path);
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw system_error(path, "its folder cannot be made", failure.value());
  struct stat info;
  if (stat(path.c_str(), &info) == 0) require_regular(path, info, "a file to write");
  remove_stale_half_files(folder.string());
  temporary_ = (folder / half_file_name(fs::path(path).filename().string(), suffix)).string();
  remove_on_signal(temporary_);
  const int fd = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) {
    const int reason = errno;
    keep_on_signal(temporary_);
    throw system_error(path, "cannot be written", reason);
  }
  ::close(fd);  // empty: nothing can be lost
}

AtomicFile::~AtomicFile() {
  if (!committed_) ::unlink(temporary_.c_str());
  keep_on_signal(temporary_);
}

bool AtomicFile::commit() {
  const int fd = ::open(temporary_.c_str(), O_RDONLY);
  if (fd < 0) throw system_error(path_, "cannot be written", errno);
  const int synced = ::fsync(fd);
  const int sync_error = errno;
  ::close(fd);
  // EINVAL: a file system that cannot sync (some tmpfs and FUSE); the rename is still atomic there.
  if (synced != 0 && sync_error != EINVAL) throw system_error(path_, "cannot be written", sync_error);
  if (same_bytes(temporary_, path_)) {
    ::unlink(temporary_.c_str());
    committed_ = true;
    return false;
  }
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) throw system_error(path_, "cannot be written", errno);
  committed_ = true;
  return true;
}

FileWriter::FileWriter(const std::string& path) : path_(path), file_(path) {
  descriptor_ = ::open(file_.temporary_path().c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (descriptor_ < 0) throw system_error(path, "cannot be written", errno);
}

FileWriter::~FileWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

// A descriptor's position is always the end of what was written.
void FileWriter::append(const char* bytes, size_t count) {
  for (size_t done = 0; done < count;) {
    const ssize_t n = ::write(descriptor_, bytes + done, count - done);
    if (n >= 0) done += static_cast<size_t>(n);
    if (n < 0 && errno != EINTR) throw system_error(path_, "cannot be written", errno);
  }
}

void FileWriter::flush() {
  append(waiting_.data(), waiting_.size());
  waiting_.clear();
}

void FileWriter::write(const void* bytes, size_t count) {
  constexpr size_t kPiece = size_t{1} << 20;
  if (waiting_.size() + count > kPiece) flush();
  written_ += count;
  if (count > kPiece) {
    append(static_cast<const char*>(bytes), count);
  } else {
    waiting_.append(static_cast<const char*>(bytes), count);
  }
}

void FileWriter::skip(uint64_t count) {
  flush();
  written_ += count;
  if (::ftruncate(descriptor_, static_cast<off_t>(written_)) != 0 ||
      ::lseek(descriptor_, static_cast<off_t>(written_), SEEK_SET) < 0)
    throw system_error(path_, "cannot be written", errno);
}

void FileWriter::overwrite(uint64_t at, const void* bytes, size_t count) {
  flush();
  for (size_t done = 0; done < count;) {
    const ssize_t n =
        ::pwrite(descriptor_, static_cast<const char*>(bytes) + done, count - done, static_cast<off_t>(at + done));
    if (n >= 0) done += static_cast<size_t>(n);
    if (n < 0 && errno != EINTR) throw system_error(path_, "cannot be written", errno);
  }
}

bool FileWriter::commit() {
  flush();
  // Some file systems tell only here that the disk is full.
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) throw system_error(path_, "cannot be written", errno);
  return file_.commit();
}

bool write_file(const std::string& path, const std::string& bytes) {
  FileWriter out(path);
  out.write(bytes);
  return out.commit();
}

std::string portable_path(const std::string& path, const std::string& folder) {
  const fs::path whole = canonical(path), base = canonical(folder);
  const std::string relative = whole.lexically_relative(base).generic_string();
  if (relative.empty() || relative.rfind("../../../", 0) == 0)
    return (whole.empty() ? fs::path(path) : whole).filename().generic_string();
  return relative;
}

std::string resolve_inside(const std::string& folder, const std::string& relative, const std::string& file,
                           const std::string& field) {
  const fs::path path(relative);
  const std::string normal = path.lexically_normal().generic_string();
  if (relative.empty() || path.is_absolute() || normal == ".." || normal.rfind("../", 0) == 0 ||
      relative.find('\0') != std::string::npos) {
    throw invalid_input({file, field, "\"" + relative + "\"", "a relative path that stays inside the bundle's folder",
                         "copy the file into the bundle"});
  }
  const std::string inside = (fs::path(folder) / normal).string();
  // A link that the bundle holds leads anywhere. What does not exist is for the reader to say.
  const fs::path target = canonical(inside), base = canonical(folder);
  const std::string from_base = target.lexically_relative(base).generic_string();
  if (from_base.empty() || from_base == ".." || from_base.rfind("../", 0) == 0) {
    throw invalid_input({file, field, "\"" + relative + "\", a link that leaves the bundle's folder",
                         "a file inside the bundle's folder", "copy the file into the bundle"});
  }
  return inside;
}

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

std::string join_path(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

}  // namespace physmas
