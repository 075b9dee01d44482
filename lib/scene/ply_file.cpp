#include "scene/ply_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>

#include "base/error.h"
#include "base/file.h"

namespace physmas {
namespace {

// No real header comes near this; without a limit a binary file without end_header would be searched to its end.
constexpr size_t kMaxHeaderBytes = size_t{1} << 20;
// Names are searched linearly; no real file declares this many elements, or properties of one.
constexpr size_t kMaxDeclarations = 1024;
constexpr size_t kTextSample = 4096;  // bytes that tell text from numbers
constexpr size_t kHeldBytes = size_t{4} << 20;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

// Printable form of bytes that may be anything.
std::string quoted(const std::string& bytes) {
  std::string text = "\"";
  for (char c : bytes.substr(0, 40)) text += (c >= 0x20 && c < 0x7f) ? c : '?';
  return text + (bytes.size() > 40 ? "...\"" : "\"");
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> words;
  size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && is_space(line[i])) ++i;
    const size_t start = i;
    while (i < line.size() && !is_space(line[i])) ++i;
    if (i > start) words.push_back(line.substr(start, i - start));
  }
  return words;
}

bool parse_type(const std::string& name, PlyType* type) {
  struct Name {
    const char* name;
    PlyType type;
  };
  static constexpr Name kNames[] = {
      {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
      {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
      {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
      {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
      {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
      {"float64", PlyType::float64}};
  for (const Name& entry : kNames) {
    if (name == entry.name) {
      *type = entry.type;
      return true;
    }
  }
  return false;
}

template <typename T>
T load(const char* at, bool swap) {
  char raw[sizeof(T)];
  std::memcpy(raw, at, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

// Whether the body is made of nothing but what an ascii PLY body holds.
bool reads_as_text(const char* begin, size_t size) {
  const size_t n = std::min<size_t>(size, kTextSample);
  if (n < 16) return false;
  for (size_t i = 0; i < n; ++i) {
    const char c = begin[i];
    const bool numeric = (c >= '0' && c <= '9') || (c != '\0' && std::strchr("+-.eE", c) != nullptr);
    if (!is_space(c) && !numeric) return false;
  }
  return true;
}

}  // namespace

size_t ply_type_size(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      return 8;
  }
  return 0;
}

int PlyElement::find(const std::string& property) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return static_cast<int>(i);
  }
  return -1;
}

PlyBytes::PlyBytes(const std::string& path, uint64_t limit)
    : path_(path), descriptor_(open_regular_file(path)), size_(regular_file_size(path)) {
  if (size_ <= limit) return;
  close(descriptor_);
  throw invalid_input({path, "size", fmt::format("{} bytes", size_), fmt::format("at most {} bytes", limit)});
}

PlyBytes::~PlyBytes() {
  if (descriptor_ >= 0) close(descriptor_);
}

const char* PlyBytes::view(uint64_t at, size_t count) const {
  if (memory_ != nullptr) return memory_->data() + at;
  if (at >= begin_ && at + count <= begin_ + held_.size()) return held_.data() + (at - begin_);
  held_.resize(static_cast<size_t>(std::min<uint64_t>(std::max(kHeldBytes, count), size_ - at)));
  begin_ = at;
  for (size_t done = 0; done < held_.size();) {
    const ssize_t got = pread(descriptor_, &held_[done], held_.size() - done, static_cast<off_t>(at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw system_error(path_, "cannot be read", errno);
    if (got == 0) throw invalid_input({path_, "size", "a file that became shorter while it was read", "one at rest"});
    done += static_cast<size_t>(got);
  }
  return held_.data();
}

PlyFile::PlyFile(std::string path, const std::string& bytes)
    : path_(std::move(path)), bytes_(std::make_unique<PlyBytes>(bytes)) {
  read();
}

PlyFile::PlyFile(const std::string& path, uint64_t limit)
    : path_(path), bytes_(std::make_unique<PlyBytes>(path, limit)) {
  read();
}

void PlyFile::read() {
  const auto first = static_cast<size_t>(std::min<uint64_t>(bytes_->size(), kMaxHeaderBytes));
  parse_header(std::string(bytes_->view(0, first), first));
  bool lists = false;
  for (const PlyElement& element : elements_) {
    for (const PlyProperty& property : element.properties) lists |= property.is_list;
  }
  if (!bytes_->in_memory() && (lists || format_ == PlyFormat::ascii)) {
    whole_ = read_file(path_, bytes_->size());
    bytes_ = std::make_unique<PlyBytes>(whole_);
  }
  if (format_ == PlyFormat::ascii) {
    locate_text_elements();
  } else {
    locate_binary_elements();
  }
}

const std::string& PlyFile::text() const {
  return bytes_->memory();
}

bool PlyFile::is_ply(const std::string& bytes) {
  return bytes.compare(0, 4, "ply\n") == 0 || bytes.compare(0, 4, "ply\r") == 0;
}

const PlyElement* PlyFile::find(const std::string& name) const {
  for (const PlyElement& element : elements_) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

void PlyFile::parse_header(const std::string& text) {
  if (!is_ply(text)) throw invalid_input({path_, "byte 0", quoted(text.substr(0, 4)), "the PLY magic \"ply\""});
  bool have_format = false;
  size_t at = 0;
  for (int line_number = 1;; ++line_number) {
    const size_t end = text.find('\n', at);
    if (end == std::string::npos) {
      const std::string found = bytes_->size() <= kMaxHeaderBytes
                                    ? fmt::format("the end of the file at byte {}", bytes_->size())
                                    : fmt::format("no end within {} bytes", kMaxHeaderBytes);
      throw invalid_input({path_, "header", found, "a line \"end_header\"", "the file may be cut off"});
    }
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::vector<std::string> words = split(line);
    const auto bad_line = [&](const std::string& expected) {
      return invalid_input({path_, fmt::format("header line {}", line_number), quoted(line), expected});
    };
    if (line_number == 1) continue;
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      const size_t start = line.find("comment") + 7, last = line.find_last_not_of("\r");
      if (comments_.size() < kMaxDeclarations && last > start)
        comments_.push_back(line.substr(start + 1, last - start));
      continue;
    }
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      if (words.size() != 3 || words[2] != "1.0" || have_format) throw bad_line("one line \"format KIND 1.0\"");
      if (words[1] == "ascii") {
        format_ = PlyFormat::ascii;
      } else if (words[1] == "binary_little_endian") {
        format_ = PlyFormat::binary_little_endian;
      } else if (words[1] == "binary_big_endian") {
        format_ = PlyFormat::binary_big_endian;
      } else {
        throw bad_line("ascii, binary_little_endian or binary_big_endian");
      }
      have_format = true;
    } else if (words[0] == "element") {
      if (words.size() != 3) throw bad_line("\"element NAME COUNT\"");
      PlyElement element;
      element.name = words[1];
      const char* last = words[2].data() + words[2].size();
      const auto parsed = std::from_chars(words[2].data(), last, element.count);
      if (parsed.ec != std::errc() || parsed.ptr != last) throw bad_line("a row count, 0 or more");
      if (find(element.name) != nullptr) throw bad_line("every element once");
      if (elements_.size() == kMaxDeclarations) throw bad_line(fmt::format("at most {} elements", kMaxDeclarations));
      elements_.push_back(element);
    } else if (words[0] == "property") {
      if (elements_.empty()) throw bad_line("an element before its properties");
      PlyProperty property;
      property.is_list = words.size() == 5 && words[1] == "list";
      if (!property.is_list && words.size() != 3) throw bad_line("\"property TYPE NAME\"");
      const std::string& type = property.is_list ? words[3] : words[1];
      property.name = words.back();
      static const char kTypes[] = "a PLY type (char, uchar, short, ushort, int, uint, float, double)";
      if (!parse_type(type, &property.type)) throw bad_line(kTypes);
      if (property.is_list) {
        if (!parse_type(words[2], &property.count_type)) throw bad_line(kTypes);
        if (property.count_type == PlyType::float32 || property.count_type == PlyType::float64) {
          throw bad_line("an integer type for the list's length");
        }
      }
      if (elements_.back().find(property.name) >= 0) throw bad_line("every property once");
      if (elements_.back().properties.size() == kMaxDeclarations) {
        throw bad_line(fmt::format("at most {} properties", kMaxDeclarations));
      }
      elements_.back().properties.push_back(property);
    } else {
      throw bad_line("format, element, property, comment, obj_info or end_header");
    }
  }
  if (!have_format) throw invalid_input({path_, "header", "no format line", "\"format binary_little_endian 1.0\""});
  body_ = at;
}

void PlyFile::locate_binary_elements() {
  const auto start = static_cast<size_t>(std::min<uint64_t>(bytes_->size() - body_, kTextSample));
  if (reads_as_text(bytes_->view(body_, start), start)) {
    throw invalid_input({path_, fmt::format("byte {}", body_), "text", "the binary values that the header declares",
                         "the format line should perhaps say ascii"});
  }
  size_t at = body_;
  for (PlyElement& element : elements_) {
    element.begin = at;
    size_t fixed = 0;  // bytes per row without the entries of lists
    bool has_list = false;
    for (const PlyProperty& property : element.properties) {
      has_list |= property.is_list;
      fixed += ply_type_size(property.is_list ? property.count_type : property.type);
    }
    if (!has_list) element.row_size = fixed;
    if (fixed == 0) continue;
    const size_t left = bytes_->size() - at;
    if (element.count > left / fixed) {
      throw invalid_input({path_, "element " + element.name, fmt::format("{} bytes from byte {} on", left, at),
                           fmt::format("{} rows of {}{} bytes", element.count, has_list ? "at least " : "", fixed),
                           "the file is cut off or its count is wrong"});
    }
    if (!has_list) {
      at += element.count * fixed;
      continue;
    }
    for (uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) {
        const size_t size = ply_type_size(property.is_list ? property.count_type : property.type);
        const auto check = [&](double length, size_t each) {
          if (length >= 0 && length * static_cast<double>(each) <= static_cast<double>(bytes_->size() - at)) return;
          throw invalid_input({path_, fmt::format("element {} row {} property {}", element.name, row, property.name),
                               fmt::format("{} bytes left at byte {}", bytes_->size() - at, at),
                               fmt::format("{} values of {} bytes", length, each)});
        };
        check(1, size);
        const double length = property.is_list ? binary_value(at, property.count_type) : 0;
        at += size;
        if (property.is_list) {
          check(length, ply_type_size(property.type));
          at += static_cast<size_t>(length) * ply_type_size(property.type);
        }
      }
    }
  }
  trailing_ = bytes_->size() - at;
}

void PlyFile::locate_text_elements() {
  const std::string& bytes = text();
  size_t at = body_;
  for (PlyElement& element : elements_) {
    element.begin = at;
    if (element.properties.empty()) continue;
    // A value takes a digit and a separator; the very last separator may be missing.
    const size_t values = (bytes.size() - at + 1) / 2;
    if (element.count > values / element.properties.size()) {
      throw invalid_input({path_, "element " + element.name, fmt::format("{} bytes", bytes.size() - at),
                           fmt::format("{} rows of {} values", element.count, element.properties.size()),
                           "the file is cut off or its count is wrong"});
    }
    for (uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) {
        const uint64_t length = property.is_list ? text_list_length(at, element, property, row) : 1;
        for (uint64_t i = 0; i < length; ++i) next_token(at, element, row);
      }
    }
  }
  while (at < bytes.size() && is_space(bytes[at])) ++at;
  trailing_ = bytes.size() - at;
}

std::string PlyFile::next_token(size_t& at, const PlyElement& element, uint64_t row) const {
  const std::string& bytes = text();
  while (at < bytes.size() && is_space(bytes[at])) ++at;
  const size_t start = at;
  while (at < bytes.size() && !is_space(bytes[at])) ++at;
  if (at == start) {
    throw invalid_input({path_, fmt::format("element {} row {}", element.name, row),
                         fmt::format("the end of the file at byte {}", at), fmt::format("{} rows", element.count),
                         "the file is cut off or its count is wrong"});
  }
  return bytes.substr(start, at - start);
}

double PlyFile::text_value(const std::string& token, PlyType type, const PlyElement& element,
                           const PlyProperty& property, uint64_t row) const {
  // strtof rounds once to float32, which a detour over double would not.
  char* end = nullptr;
  const double value = type == PlyType::float32 ? std::strtof(token.c_str(), &end) : std::strtod(token.c_str(), &end);
  if (end != token.c_str() + token.size()) {
    throw invalid_input({path_, fmt::format("element {} row {} property {}", element.name, row, property.name),
                         quoted(token), "a number"});
  }
  return value;
}

uint64_t PlyFile::text_list_length(size_t& at, const PlyElement& element, const PlyProperty& property,
                                   uint64_t row) const {
  const std::string token = next_token(at, element, row);
  uint64_t length = 0;
  const auto parsed = std::from_chars(token.data(), token.data() + token.size(), length);
  if (parsed.ec != std::errc() || parsed.ptr != token.data() + token.size() || length > text().size() - at) {
    throw invalid_input({path_, fmt::format("element {} row {} property {}", element.name, row, property.name),
                         quoted(token), "a list length that the file has room for"});
  }
  return length;
}

double PlyFile::binary_value(size_t at, PlyType type) const {
  const char* p = bytes_->view(at, ply_type_size(type));
  const bool swap = format_ == PlyFormat::binary_big_endian;
  switch (type) {
    case PlyType::int8:
      return load<int8_t>(p, false);
    case PlyType::uint8:
      return load<uint8_t>(p, false);
    case PlyType::int16:
      return load<int16_t>(p, swap);
    case PlyType::uint16:
      return load<uint16_t>(p, swap);
    case PlyType::int32:
      return load<int32_t>(p, swap);
    case PlyType::uint32:
      return load<uint32_t>(p, swap);
    case PlyType::float32:
      return load<float>(p, swap);
    case PlyType::float64:
      return load<double>(p, swap);
  }
  return 0;
}

void PlyFile::read_rows(const PlyElement& element, const std::vector<int>& wanted,
                        const std::function<void(size_t row, const double* values)>& visit) const {
  std::vector<double> values(wanted.size());
  if (format_ != PlyFormat::ascii) {
    if (element.row_size == 0) throw internal_error("rows of a PLY element with lists were asked for");
    std::vector<size_t> offsets(element.properties.size(), 0);
    for (size_t i = 1; i < offsets.size(); ++i) {
      offsets[i] = offsets[i - 1] + ply_type_size(element.properties[i - 1].type);
    }
    for (size_t row = 0; row < element.count; ++row) {
      const size_t begin = element.begin + row * element.row_size;
      bytes_->view(begin, element.row_size);  // at once: a row may lie across what is held
      for (size_t k = 0; k < wanted.size(); ++k) {
        values[k] = binary_value(begin + offsets[wanted[k]], element.properties[wanted[k]].type);
      }
      visit(row, values.data());
    }
    return;
  }
  std::vector<int> slot(element.properties.size(), -1);
  for (size_t k = 0; k < wanted.size(); ++k) slot[wanted[k]] = static_cast<int>(k);
  size_t at = element.begin;
  for (size_t row = 0; row < element.count; ++row) {
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      const uint64_t length = property.is_list ? text_list_length(at, element, property, row) : 1;
      for (uint64_t i = 0; i < length; ++i) {
        const std::string token = next_token(at, element, row);
        if (slot[p] >= 0) values[slot[p]] = text_value(token, property.type, element, property, row);
      }
    }
    visit(row, values.data());
  }
}

}  // namespace physmas
