// Makes .npy and .npz files, for tests and seeds.
#ifndef PHYSMAS_TESTS_NPZ_BYTES_H
#define PHYSMAS_TESTS_NPZ_BYTES_H

#include <zlib.h>

#include <string>
#include <utility>
#include <vector>

#include "unit/base/deflate_bytes.h"

namespace physmas::testing {

inline std::string le(unsigned long value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i, value >>= 8) out += static_cast<char>(value & 0xff);
  return out;
}

template <typename T>
std::string npy(const std::string& descr, const std::string& shape, const std::vector<T>& values) {
  std::string header = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': " + shape + ", }";
  header.resize((10 + header.size() + 64) / 64 * 64 - 10, ' ');
  header.back() = '\n';
  std::string out = std::string("\x93NUMPY\x01\x00", 8) + le(header.size(), 2) + header;
  return out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

// An archive as zip and numpy write it.
inline std::string zip(const std::vector<std::pair<std::string, std::string>>& entries, bool deflate) {
  std::string out, directory;
  for (const auto& [name, data] : entries) {
    const std::string body = deflate ? deflated(data, kRawDeflate) : data;
    const unsigned long crc = crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size()));
    const std::string middle = le(deflate ? 8 : 0, 2) + le(0, 4) + le(crc, 4) + le(body.size(), 4) +
                               le(data.size(), 4) + le(name.size(), 2) + le(0, 2);
    directory += "PK\x01\x02" + le(20, 2) + le(20, 2) + le(0, 2) + middle + le(0, 10) + le(out.size(), 4) + name;
    out += "PK\x03\x04" + le(20, 2) + le(0, 2) + middle + name + body;
  }
  const size_t start = out.size();
  out += directory;
  return out + "PK\x05\x06" + le(0, 4) + le(entries.size(), 2) + le(entries.size(), 2) + le(directory.size(), 4) +
         le(start, 4) + le(0, 2);
}

}  // namespace physmas::testing

#endif
