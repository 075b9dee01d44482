#include "base/zip_archive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zip.h>

#include "base/error.h"

namespace physmas {
namespace {

constexpr size_t kMaxEntry = size_t{1} << 29;
constexpr size_t kMaxDeflateRatio = 1032;

}  // namespace

ZipArchive::ZipArchive(const std::string& bytes, const std::string& file) : file_(file), zip_(nullptr, zip_discard) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_.reset(source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY, &error));
  if (!zip_) {
    const std::string problem = one_line(zip_error_strerror(&error));
    zip_source_free(source);
    zip_error_fini(&error);
    throw invalid_input({file_, "", "\"" + problem + "\"", "a whole ZIP archive"});
  }
  const zip_int64_t count = zip_get_num_entries(zip_.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* name = zip_get_name(zip_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_RAW);
    if (name == nullptr || !names_.insert(name).second)
      throw invalid_input({file_, fmt::format("entry {}", i), "a name that occurs twice", "each name once"});
  }
}

std::string ZipArchive::read(const std::string& name) const {
  zip_stat_t entry;
  const zip_int64_t index = zip_name_locate(zip_.get(), name.c_str(), ZIP_FL_ENC_RAW);
  if (index < 0 || zip_stat_index(zip_.get(), static_cast<zip_uint64_t>(index), 0, &entry) != 0)
    throw invalid_input(
        {file_, name, "no such entry", one_line(fmt::format("it among {}", fmt::join(names_, ", ")), 200)});
  if (entry.encryption_method != ZIP_EM_NONE) throw invalid_input({file_, name, "an encrypted entry", "a plain one"});
  if (entry.comp_method != ZIP_CM_STORE && entry.comp_method != ZIP_CM_DEFLATE)
    throw invalid_input(
        {file_, name, fmt::format("compression method {}", entry.comp_method), "0 (stored) or 8 (deflate)"});
  if (entry.size > kMaxEntry)
    throw invalid_input({file_, name, fmt::format("{} bytes", entry.size), fmt::format("at most {} bytes", kMaxEntry)});
  // Checked before anything of that size is allocated.
  if (entry.comp_method == ZIP_CM_STORE ? entry.size != entry.comp_size
                                        : entry.size / kMaxDeflateRatio > entry.comp_size)
    throw invalid_input({file_, name, fmt::format("{} bytes from {}", entry.size, entry.comp_size), "sizes that fit"});
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> stream(
      zip_fopen_index(zip_.get(), static_cast<zip_uint64_t>(index), 0), zip_fclose);
  std::string out(entry.size, '\0');
  char more = 0;
  // The checksum is compared at the end, which only reading beyond it reaches.
  if (!stream || zip_fread(stream.get(), out.data(), entry.size) != static_cast<zip_int64_t>(entry.size) ||
      zip_fread(stream.get(), &more, 1) != 0)
    throw invalid_input({file_, name, "damaged data", "what its size and checksum say"});
  return out;
}

}  // namespace physmas
