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

std::string read_file(const std::string& path, size_t limit) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0) throw system_error(path, "cannot be read", errno);
  if (S_ISDIR(info.st_mode)) throw invalid_input({path, "", "a folder", "a file"});
  const File file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw system_error(path, "cannot be read", errno);
  std::string bytes;
  // Growing piece by piece would need twice the memory for a moment.
  if (S_ISREG(info.st_mode)) bytes.reserve(std::min(static_cast<size_t>(info.st_size), limit));
  // A small file does not pay for a large buffer.
  const size_t usual = size_t{1} << 20;
  std::string buffer(S_ISREG(info.st_mode) ? std::min(static_cast<size_t>(info.st_size) + 1, usual) : usual, '\0');
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
  if (fs::is_directory(path, failure)) throw invalid_input({path, "", "a folder", "a file to write"});
  // The process id keeps parallel jobs apart; the leading dot keeps half files out of listings.
  temporary_ = (folder / fmt::format(".{}.{}.tmp{}", fs::path(path).filename().string(), getpid(), suffix)).string();
  remove_on_signal(temporary_);
  const int fd = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (fd < 0) {
    const int reason = errno;
    keep_on_signal(temporary_);
    throw system_error(path, "cannot be written", reason);
  }
  ::close(fd);
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

bool write_file(const std::string& path, const std::string& bytes) {
  AtomicFile out(path);
  FILE* file = std::fopen(out.temporary_path().c_str(), "wb");
  if (file == nullptr) throw system_error(path, "cannot be written", errno);
  const size_t written = std::fwrite(bytes.data(), 1, bytes.size(), file);
  const int write_error = errno;
  // A full disk may show itself only when the buffer is flushed.
  if (std::fclose(file) != 0) throw system_error(path, "cannot be written", errno);
  if (written != bytes.size()) throw system_error(path, "cannot be written", write_error);
  return out.commit();
}

std::string portable_path(const std::string& path, const std::string& folder) {
  std::error_code failure;
  // Absolute first: weakly_canonical leaves a relative path relative when its first folder does not exist yet.
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, failure), failure);
  const fs::path base = fs::weakly_canonical(fs::absolute(folder, failure), failure);
  const std::string relative = whole.lexically_relative(base).generic_string();
  if (relative.empty() || relative.rfind("../../../", 0) == 0) return whole.filename().generic_string();
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
  return (fs::path(folder) / normal).string();
}

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

std::string join_path(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

}  // namespace physmas
