// Makes .spz files, for tests and seeds.
#ifndef PHYSMAS_TESTS_SPZ_BYTES_H
#define PHYSMAS_TESTS_SPZ_BYTES_H

#include <zstd.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/gaussians.h"
#include "unit/base/deflate_bytes.h"

namespace physmas::testing {

struct SpzGaussian {
  std::array<int32_t, 3> position = {0, 0, 0};  // 24 bits; version 1: the 16 of a half
  uint8_t opacity = 200;
  std::array<uint8_t, 3> color = {128, 128, 128};
  std::array<uint8_t, 3> scale = {100, 100, 100};
  std::array<uint8_t, 4> rotation = {128, 128, 128, 192};  // version 2 takes the first three
  std::vector<uint8_t> harmonics;

  static SpzGaussian with_degree(int degree) {
    SpzGaussian g;
    g.harmonics.assign(3 * (sh_coefficient_count(degree) - 1), 128);
    return g;
  }
};

inline std::string spz_body(int version, int degree, const std::vector<SpzGaussian>& gaussians, int bits = 12) {
  const uint32_t n = static_cast<uint32_t>(gaussians.size());
  std::string bytes = "NGSP";
  bytes += {static_cast<char>(version), 0, 0, 0};
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(n >> 8 * k & 255);
  bytes += {static_cast<char>(degree), static_cast<char>(bits), 0, 0};
  for (const auto& g : gaussians) {
    for (int32_t p : g.position) {
      for (int k = 0; k < (version == 1 ? 2 : 3); ++k) bytes += static_cast<char>(p >> 8 * k & 255);
    }
  }
  for (const auto& g : gaussians) bytes += static_cast<char>(g.opacity);
  for (const auto& g : gaussians) bytes.append(g.color.begin(), g.color.end());
  for (const auto& g : gaussians) bytes.append(g.scale.begin(), g.scale.end());
  for (const auto& g : gaussians) bytes.append(g.rotation.begin(), g.rotation.begin() + (version < 3 ? 3 : 4));
  for (const auto& g : gaussians) bytes.append(g.harmonics.begin(), g.harmonics.end());
  return bytes;
}

// Version 4: a header of 32 bytes, extension records, a table and a zstd stream per array of `body`, which is a whole
// file of version 3 without extensions. flags: of the header.
inline std::string spz4(const std::string& body, int flags = 0, const std::string& extensions = "") {
  const auto number = [](uint64_t value, int bytes) {
    std::string out;
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(value >> 8 * k & 255);
    return out;
  };
  uint32_t n = 0;
  for (int k = 0; k < 4; ++k) n |= static_cast<uint32_t>(static_cast<uint8_t>(body[8 + k])) << 8 * k;
  const size_t degree = static_cast<uint8_t>(body[12]);
  std::string table, streams;
  size_t at = 16;
  for (size_t each : {size_t{9}, size_t{1}, size_t{3}, size_t{3}, size_t{4}, 3 * ((degree + 1) * (degree + 1) - 1)}) {
    std::string packed(ZSTD_compressBound(each * n), '\0');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), body.data() + at, each * n, 3));
    table += number(packed.size(), 8) + number(each * n, 8);
    streams += packed;
    at += each * n;
  }
  return "NGSP" + number(4, 4) + body.substr(8, 6) + static_cast<char>(flags | (extensions.empty() ? 0 : 2)) + '\6' +
         number(32 + extensions.size(), 4) + std::string(12, '\0') + extensions + table + streams;
}

inline std::string gzip(const std::string& bytes) {
  return deflated(bytes, kGzip);
}

}  // namespace physmas::testing

#endif
