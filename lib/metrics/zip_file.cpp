#include "metrics/zip_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include "base/error.h"

namespace physmas::metrics {
namespace {

constexpr size_t kMaxEntry = size_t{1} << 29;
constexpr size_t kEndSize = 22, kCentralSize = 46, kLocalSize = 30;
constexpr unsigned long kNone = 0xffffffff;  // "see the 64-bit field"
constexpr unsigned kStored = 0, kDeflated = 8;
constexpr size_t kMaxRatio = 1032;  // of deflate

std::string inflated(const char* data, size_t compressed, size_t size) {
  std::string out(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw internal_error("zlib does not start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data));
  stream.avail_in = static_cast<uInt>(compressed);
  stream.next_out = reinterpret_cast<Bytef*>(&out[0]);
  stream.avail_out = static_cast<uInt>(size);
  const int result = inflate(&stream, Z_FINISH);
  const bool whole = result == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  return whole ? out : std::string();
}

}  // namespace

// Little-endian. Reading past the end is refused.
unsigned long ZipFile::number(size_t at, int bytes) const {
  if (at > bytes_.size() || bytes_.size() - at < static_cast<size_t>(bytes))
    throw invalid_input({file_, fmt::format("byte {}", at), "the end of the file", "a whole ZIP archive"});
  unsigned long value = 0;
  for (int i = bytes - 1; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes_[at + i]);
  return value;
}

ZipFile::ZipFile(std::string bytes, std::string file) : bytes_(std::move(bytes)), file_(std::move(file)) {
  const size_t end = bytes_.rfind("PK\x05\x06");
  if (end == std::string::npos) throw invalid_input({file_, "", "no directory of entries", "a whole ZIP archive"});
  if (end + kEndSize > bytes_.size())
    throw invalid_input({file_, fmt::format("byte {}", end), "a directory that is cut off", "a whole ZIP archive"});
  const unsigned long count = number(end + 10, 2);
  size_t at = number(end + 16, 4);
  for (unsigned long i = 0; i < count; ++i) {
    const std::string field = fmt::format("entry {}", i);
    if (number(at, 4) != 0x02014b50) throw invalid_input({file_, field, "no entry", "a ZIP directory entry"});
    Entry entry;
    entry.method = static_cast<unsigned>(number(at + 10, 2));
    entry.crc = number(at + 16, 4);
    entry.compressed = number(at + 20, 4);
    entry.size = number(at + 24, 4);
    entry.local_header = number(at + 42, 4);
    const size_t name_size = number(at + 28, 2), extra = number(at + 30, 2) + number(at + 32, 2);
    if ((number(at + 8, 2) & 1) != 0) throw invalid_input({file_, field, "an encrypted entry", "a plain one"});
    if (entry.compressed == kNone || entry.size == kNone || entry.local_header == kNone || entry.size > kMaxEntry)
      throw invalid_input({file_, field, "a larger entry", fmt::format("at most {} bytes", kMaxEntry)});
    if (entry.method != kStored && entry.method != kDeflated)
      throw invalid_input(
          {file_, field, fmt::format("compression method {}", entry.method), "0 (stored) or 8 (deflate)"});
    // Checked before anything of that size is allocated.
    if (entry.method == kStored ? entry.size != entry.compressed : entry.size > kMaxRatio * (entry.compressed + 1))
      throw invalid_input(
          {file_, field, fmt::format("{} bytes from {}", entry.size, entry.compressed), "sizes that fit"});
    if (at + kCentralSize + name_size > bytes_.size())
      throw invalid_input({file_, field, "a name that is cut off", "a whole ZIP archive"});
    if (!entries_.emplace(bytes_.substr(at + kCentralSize, name_size), entry).second)
      throw invalid_input({file_, field, "a name that occurs twice", "each name once"});
    at += kCentralSize + name_size + extra;
  }
}

std::vector<std::string> ZipFile::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

std::string ZipFile::read(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) {
    std::string known;
    for (const auto& [other, entry] : entries_) known += (known.empty() ? "" : ", ") + other;
    throw invalid_input({file_, name, "no such entry", "it among " + one_line(known, 200)});
  }
  const Entry& entry = found->second;
  const size_t header = entry.local_header;
  if (number(header, 4) != 0x04034b50) throw invalid_input({file_, name, "no header", "a ZIP entry's header"});
  const size_t data = header + kLocalSize + number(header + 26, 2) + number(header + 28, 2);
  if (data > bytes_.size() || bytes_.size() - data < entry.compressed)
    throw invalid_input({file_, name, "data that is cut off", "a whole ZIP archive"});
  std::string out =
      entry.method == kStored ? bytes_.substr(data, entry.size) : inflated(&bytes_[data], entry.compressed, entry.size);
  if (out.size() != entry.size ||
      crc32(0, reinterpret_cast<const Bytef*>(out.data()), static_cast<uInt>(out.size())) != entry.crc)
    throw invalid_input({file_, name, "damaged data", "what its checksum says"});
  return out;
}

}  // namespace physmas::metrics
