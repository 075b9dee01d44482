// Entries of a ZIP archive (PKWARE APPNOTE 6.3): stored and deflated ones, as numpy writes .npz files.
#ifndef PHYSMAS_METRICS_ZIP_FILE_H
#define PHYSMAS_METRICS_ZIP_FILE_H

#include <map>
#include <string>
#include <vector>

namespace physmas::metrics {

class ZipFile {
 public:
  // bytes: the archive. file: for messages. Errors (exit code 3): anything that does not fit the format; encrypted,
  // split and 64-bit archives; entries above 2^29 bytes; a name that occurs twice.
  ZipFile(std::string bytes, std::string file);
  std::vector<std::string> names() const;
  // The entry's bytes, checked against their CRC. Error (exit code 3) when there is none of that name.
  std::string read(const std::string& name) const;

 private:
  struct Entry {
    unsigned method = 0;
    unsigned long crc = 0;
    size_t compressed = 0, size = 0, local_header = 0;
  };
  unsigned long number(size_t at, int bytes) const;

  std::string bytes_, file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace physmas::metrics

#endif
