#include "remote/tensor_bytes.h"

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>

namespace physmas::remote {
namespace {

// The hosts that this is built for are little-endian as well.
template <class Value>
void append(std::string& bytes, Value value) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  bytes.append(raw, sizeof(Value));
}

template <class Value>
Value read(const std::string& bytes, size_t at) {
  Value value;
  std::memcpy(&value, bytes.data() + at, sizeof(Value));
  return value;
}

struct Codec {
  size_t size;
  void (*write)(std::string&, double);
  double (*read)(const std::string&, size_t);
};

template <class Value>
Codec plain() {
  return {sizeof(Value), [](std::string& bytes, double x) { append(bytes, static_cast<Value>(x)); },
          [](const std::string& bytes, size_t at) { return static_cast<double>(read<Value>(bytes, at)); }};
}

template <class Half>
Codec half() {
  return {
      2,
      [](std::string& bytes, double x) {
        append(bytes, Eigen::numext::bit_cast<std::uint16_t>(static_cast<Half>(static_cast<float>(x))));
      },
      [](const std::string& bytes, size_t at) {
        return static_cast<double>(static_cast<float>(Eigen::numext::bit_cast<Half>(read<std::uint16_t>(bytes, at))));
      }};
}

const std::map<std::string, Codec>& codecs() {
  static const std::map<std::string, Codec> all = {
      {"BOOL",
       {1, [](std::string& bytes, double x) { append<std::uint8_t>(bytes, x != 0); }, plain<std::uint8_t>().read}},
      {"UINT8", plain<std::uint8_t>()},
      {"UINT16", plain<std::uint16_t>()},
      {"UINT32", plain<std::uint32_t>()},
      {"UINT64", plain<std::uint64_t>()},
      {"INT8", plain<std::int8_t>()},
      {"INT16", plain<std::int16_t>()},
      {"INT32", plain<std::int32_t>()},
      {"INT64", plain<std::int64_t>()},
      {"FP16", half<Eigen::half>()},
      {"BF16", half<Eigen::bfloat16>()},
      {"FP32", plain<float>()},
      {"FP64", plain<double>()}};
  return all;
}

}  // namespace

size_t element_size(const std::string& datatype) {
  const auto found = codecs().find(datatype);
  return found == codecs().end() ? 0 : found->second.size;
}

std::string bytes_of(const std::vector<double>& numbers, const std::string& datatype) {
  const Codec& codec = codecs().at(datatype);
  std::string bytes;
  bytes.reserve(numbers.size() * codec.size);
  for (const double x : numbers) codec.write(bytes, x);
  return bytes;
}

std::string bytes_of(const std::vector<std::string>& texts) {
  std::string bytes;
  for (const std::string& text : texts) {
    append(bytes, static_cast<std::uint32_t>(text.size()));
    bytes += text;
  }
  return bytes;
}

std::vector<double> numbers_in(const std::string& bytes, const std::string& datatype) {
  const Codec& codec = codecs().at(datatype);
  std::vector<double> numbers;
  numbers.reserve(bytes.size() / codec.size);
  for (size_t at = 0; at + codec.size <= bytes.size(); at += codec.size) numbers.push_back(codec.read(bytes, at));
  return numbers;
}

bool texts_in(const std::string& bytes, std::vector<std::string>& texts) {
  size_t at = 0;
  while (at < bytes.size()) {
    if (bytes.size() - at < 4) return false;
    const size_t length = read<std::uint32_t>(bytes, at);
    at += 4;
    if (bytes.size() - at < length) return false;
    texts.push_back(bytes.substr(at, length));
    at += length;
  }
  return true;
}

}  // namespace physmas::remote
