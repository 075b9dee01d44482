// Reading whole files, and the one way in which anything is written: to a temporary name, then renamed.
#ifndef PHYSMAS_BASE_FILE_H
#define PHYSMAS_BASE_FILE_H

#include <cstddef>
#include <cstdint>
#include <string>

namespace physmas {

// Everything that is read or replaced is a regular file, or a link to one: a pipe would hang and a device would be
// replaced. Errors (exit code 3) say what is there instead. Size in bytes.
uint64_t regular_file_size(const std::string& path);

// A regular file, open for reading; does not wait for the other end of a pipe. Errors as above.
int open_regular_file(const std::string& path);

// The file's bytes. Refuses what is no regular file, unreadable files and files above `limit` bytes (exit code 3).
std::string read_file(const std::string& path, size_t limit = size_t{1} << 30);

// An output file that appears whole or not at all. Write to `temporary_path()` by any means, then `commit()`:
// the bytes are flushed to disk and renamed onto `path`; when `path` already holds the same bytes it is left
// untouched with its timestamp, so nothing downstream reruns. Without commit the temporary file is removed; what a
// killed process left is removed by the next one that writes into that folder (base/half_files.h). All failures
// (missing folder, no permission, disk full, a device or pipe of that name) are Errors with exit code 3 that name
// `path`.
class AtomicFile {
 public:
  // Creates missing parent folders, and fails at once when the folder cannot be written.
  // suffix: kept at the end of the temporary name, for libraries that choose a format by it (".mp4").
  explicit AtomicFile(const std::string& path, const std::string& suffix = "");
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  const std::string& temporary_path() const { return temporary_; }
  // Returns whether the file changed.
  bool commit();

 private:
  std::string path_;
  std::string temporary_;
  bool committed_ = false;
};

// An AtomicFile that is written piece by piece. Errors as those of AtomicFile.
class FileWriter {
 public:
  explicit FileWriter(const std::string& path);
  ~FileWriter();
  void write(const void* bytes, size_t count);
  void write(const std::string& bytes) { write(bytes.data(), bytes.size()); }
  uint64_t written() const { return written_; }
  // So many zeros.
  void skip(uint64_t count);
  // Replaces bytes that were written before; at + count <= written().
  void overwrite(uint64_t at, const void* bytes, size_t count);
  // Returns whether the file changed.
  bool commit();

 private:
  void flush();
  void append(const char* bytes, size_t count);

  std::string path_;
  AtomicFile file_;
  int descriptor_ = -1;
  uint64_t written_ = 0;
  std::string waiting_;  // the last bytes of it, not in the file yet
};

// Writes `bytes` through an AtomicFile. Returns whether the file changed.
bool write_file(const std::string& path, const std::string& bytes);

// `path` relative to `folder` when that stays readable (at most two steps up), else the bare file name:
// how provenance names an input, so that a run's bytes do not depend on where the run lies.
std::string portable_path(const std::string& path, const std::string& folder);

// `relative` inside `folder`; refuses absolute paths and paths that leave the folder, also through symbolic links (exit
// code 3, with file and field).
std::string resolve_inside(const std::string& folder, const std::string& relative, const std::string& file,
                           const std::string& field);

// The folder part of `path`, "." when there is none.
std::string folder_of(const std::string& path);

std::string join_path(const std::string& folder, const std::string& name);

}  // namespace physmas

#endif
