#include "metrics/array_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zip.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "records/json.h"

namespace physmas::metrics {
namespace {

constexpr size_t kMaxValues = size_t{1} << 26;
constexpr size_t kMaxFile = size_t{1} << 29;
constexpr int kMaxAxes = 8;

// The entries of a ZIP archive in memory, stored and deflated ones, as numpy writes .npz files.
class Archive {
 public:
  // bytes: kept by the caller. Errors (exit code 3): bytes that are no archive, a name that occurs twice.
  Archive(const std::string& bytes, const std::string& file) : file_(file) {
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

  // The entry's bytes, checked against their CRC. Errors (exit code 3): none of that name; encrypted or compressed in
  // another way than by deflate; above 2^29 bytes; damaged.
  std::string read(const std::string& name) const {
    zip_stat_t entry;
    const zip_int64_t index = zip_name_locate(zip_.get(), name.c_str(), ZIP_FL_ENC_RAW);
    if (index < 0 || zip_stat_index(zip_.get(), static_cast<zip_uint64_t>(index), 0, &entry) != 0)
      throw invalid_input(
          {file_, name, "no such entry", one_line(fmt::format("it among {}", fmt::join(names_, ", ")), 200)});
    if (entry.encryption_method != ZIP_EM_NONE) throw invalid_input({file_, name, "an encrypted entry", "a plain one"});
    if (entry.comp_method != ZIP_CM_STORE && entry.comp_method != ZIP_CM_DEFLATE)
      throw invalid_input(
          {file_, name, fmt::format("compression method {}", entry.comp_method), "0 (stored) or 8 (deflate)"});
    if (entry.size > kMaxFile)
      throw invalid_input(
          {file_, name, fmt::format("{} bytes", entry.size), fmt::format("at most {} bytes", kMaxFile)});
    // Checked before anything of that size is allocated.
    if (entry.comp_method == ZIP_CM_STORE ? entry.size != entry.comp_size
                                          : entry.size / kMaxDeflateRatio > entry.comp_size)
      throw invalid_input(
          {file_, name, fmt::format("{} bytes from {}", entry.size, entry.comp_size), "sizes that fit"});
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

 private:
  static constexpr size_t kMaxDeflateRatio = 1032;

  std::string file_;
  std::unique_ptr<zip_t, void (*)(zip_t*)> zip_{nullptr, zip_discard};
  std::set<std::string> names_;
};

struct NpyHeader {
  std::string descr;
  bool fortran_order = false;
  std::vector<size_t> shape;
};

// The header is a Python dict literal that numpy writes in one form: {'descr': '<f4', 'fortran_order': False,
// 'shape': (1, 50, 256, 2), }.
class HeaderParser {
 public:
  HeaderParser(const std::string& text, const std::string& file, const std::string& field)
      : text_(text), file_(file), field_(field) {}

  NpyHeader parse() {
    NpyHeader header;
    header.descr = quoted(after("'descr':"));
    const size_t order = after("'fortran_order':");
    header.fortran_order = text_.compare(order, 4, "True") == 0;
    if (!header.fortran_order && text_.compare(order, 5, "False") != 0) fail();
    size_t at = after("'shape':");
    if (at >= text_.size() || text_[at] != '(') fail();
    for (++at; at < text_.size() && text_[at] != ')';) {
      if (text_[at] == ' ' || text_[at] == ',') {
        ++at;
        continue;
      }
      size_t extent = 0;
      if (text_[at] < '0' || text_[at] > '9') fail();
      for (; at < text_.size() && text_[at] >= '0' && text_[at] <= '9'; ++at) {
        extent = 10 * extent + static_cast<size_t>(text_[at] - '0');
        if (extent > kMaxValues) fail();
      }
      header.shape.push_back(extent);
    }
    if (at >= text_.size() || header.shape.size() > kMaxAxes) fail();
    return header;
  }

 private:
  [[noreturn]] void fail() const {
    throw invalid_input({file_, field_, one_line(text_, 80), "the header of an array of at most 2^26 values"});
  }
  size_t after(const std::string& key) const {
    size_t at = text_.find(key);
    if (at == std::string::npos) fail();
    at += key.size();
    while (at < text_.size() && text_[at] == ' ') ++at;
    if (at >= text_.size()) fail();
    return at;
  }
  std::string quoted(size_t at) const {
    if (text_[at] != '\'') fail();
    const size_t end = text_.find('\'', at + 1);
    if (end == std::string::npos) fail();
    return text_.substr(at + 1, end - at - 1);
  }

  const std::string &text_, &file_, &field_;
};

template <typename T>
std::vector<double> convert(const char* data, size_t count) {
  std::vector<double> values(count);
  for (size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    values[i] = static_cast<double>(value);
  }
  return values;
}

struct NpyType {
  const char* descr;
  size_t size;
  std::vector<double> (*convert)(const char*, size_t);
};
const NpyType kTypes[] = {{"<f4", 4, convert<float>},   {"<f8", 8, convert<double>}, {"|b1", 1, convert<uint8_t>},
                          {"|u1", 1, convert<uint8_t>}, {"|i1", 1, convert<int8_t>}, {"<i4", 4, convert<int32_t>},
                          {"<i8", 8, convert<int64_t>}};

// depth: of `json` in the nesting.
void flatten(const Json& json, size_t depth, Array& array, const std::string& file, const std::string& pointer) {
  if (json.is_array()) {
    if (array.values.empty() && depth == array.shape.size()) array.shape.push_back(json.size());
    if (depth >= array.shape.size() || depth >= kMaxAxes || json.size() != array.shape[depth])
      throw invalid_input({file, pointer, fmt::format("a list of {}", json.size()), "lists of even length"});
    for (size_t i = 0; i < json.size(); ++i) flatten(json[i], depth + 1, array, file, pointer);
    return;
  }
  if (depth != array.shape.size()) throw invalid_input({file, pointer, "a value beside a list", "lists of even depth"});
  if (json.is_null()) {
    array.values.push_back(std::numeric_limits<double>::quiet_NaN());
  } else if (json.is_boolean()) {
    array.values.push_back(json.get<bool>() ? 1 : 0);
  } else if (json.is_number()) {
    array.values.push_back(json.get<double>());
  } else {
    throw invalid_field(file, pointer, json, "numbers");
  }
}

}  // namespace

std::string shape_text(const std::vector<size_t>& shape) {
  return fmt::format("[{}]", fmt::join(shape, ", "));
}

Array parse_npy(const std::string& bytes, const std::string& file, const std::string& field) {
  const auto bad = [&](const std::string& found, const std::string& expected) {
    return invalid_input({file, field, found, expected});
  };
  if (bytes.size() < 12 || bytes.compare(0, 6, "\x93NUMPY") != 0) throw bad("no numpy header", "a .npy array");
  const int version = static_cast<unsigned char>(bytes[6]);
  if (version < 1 || version > 3) throw bad(fmt::format("format {}", version), "format 1 to 3");
  const size_t length_bytes = version == 1 ? 2 : 4, start = 8 + length_bytes;
  size_t length = 0;
  for (size_t i = length_bytes; i-- > 0;) length = length << 8 | static_cast<unsigned char>(bytes[8 + i]);
  if (length > bytes.size() - start) throw bad("a header that is cut off", "a whole .npy array");
  const std::string text = bytes.substr(start, length);
  const NpyHeader header = HeaderParser(text, file, field).parse();
  if (header.fortran_order && header.shape.size() > 1)
    throw invalid_input({file, field, "Fortran order", "C order", "save np.ascontiguousarray(...)"});
  // Extents beside a zero are limited, too: who reads the array may count by them.
  size_t count = 1, extents = 1;
  for (const size_t extent : header.shape) {
    if (extent > 0 && extents > kMaxValues / extent) throw bad(shape_text(header.shape), "at most 2^26 values");
    count *= extent;
    extents *= std::max<size_t>(extent, 1);
  }
  for (const NpyType& type : kTypes) {
    if (header.descr != type.descr) continue;
    if (bytes.size() - start - length != count * type.size)
      throw bad(fmt::format("{} bytes of data", bytes.size() - start - length),
                fmt::format("{} for {} of {}", count * type.size, shape_text(header.shape), header.descr));
    return {header.shape, type.convert(bytes.data() + start + length, count)};
  }
  throw bad("type " + one_line(header.descr, 40), "float32, float64, bool or an integer, little-endian");
}

std::map<std::string, Array> load_arrays(const std::string& path, const std::vector<std::string>& names) {
  return parse_arrays(read_file(path, kMaxFile), path, names);
}

std::map<std::string, Array> parse_arrays(const std::string& bytes, const std::string& file,
                                          const std::vector<std::string>& names) {
  std::map<std::string, Array> arrays;
  if (bytes.compare(0, 2, "PK") == 0) {
    const Archive zip(bytes, file);
    for (const std::string& name : names) arrays[name] = parse_npy(zip.read(name + ".npy"), file, name);
    return arrays;
  }
  const Json document = parse_json(bytes, file);
  for (const std::string& name : names) {
    if (!document.is_object() || !document.contains(name) || !document.at(name).is_array())
      throw invalid_input({file, "/" + name, "none", "nested lists of numbers"});
    flatten(document.at(name), 0, arrays[name], file, "/" + name);
  }
  return arrays;
}

}  // namespace physmas::metrics
