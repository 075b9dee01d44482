// ZIP archives in memory: numpy's .npz, SOG scenes.
#ifndef PHYSMAS_BASE_ZIP_ARCHIVE_H
#define PHYSMAS_BASE_ZIP_ARCHIVE_H

#include <memory>
#include <set>
#include <string>

struct zip;

namespace physmas {

// The entries of a ZIP archive, stored and deflated ones.
class ZipArchive {
 public:
  // bytes: kept by the caller. Errors (exit code 3): bytes that are no archive, a name that occurs twice.
  ZipArchive(const std::string& bytes, const std::string& file);

  // Whether the bytes start as an archive with an entry does.
  static bool is_zip(const std::string& bytes) { return bytes.compare(0, 4, "PK\x03\x04") == 0; }

  const std::set<std::string>& names() const { return names_; }

  // The entry's bytes, checked against their CRC. Errors (exit code 3): none of that name; encrypted or compressed in
  // another way than by deflate; above 2^29 bytes; damaged.
  std::string read(const std::string& name) const;

 private:
  std::string file_;
  std::unique_ptr<zip, void (*)(zip*)> zip_;
  std::set<std::string> names_;
};

}  // namespace physmas

#endif
