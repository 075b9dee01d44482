#include "records/array_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "base/zip_archive.h"
#include "records/json.h"

namespace physmas {
namespace {

constexpr size_t kMaxValues = size_t{1} << 26;
constexpr size_t kMaxFile = size_t{1} << 29;
constexpr int kMaxAxes = 8;

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
    const ZipArchive zip(bytes, file);
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

}  // namespace physmas
