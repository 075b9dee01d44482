// Makes .spz files, for tests and seeds.
#ifndef PHYSMAS_TESTS_SPZ_BYTES_H
#define PHYSMAS_TESTS_SPZ_BYTES_H

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/gaussians.h"
#include "unit/base/deflate_bytes.h"

namespace physmas::testing {

struct SpzGaussian {
  std::array<int32_t, 3> position = {0, 0, 0};  // 24 bits
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
      for (int k = 0; k < 3; ++k) bytes += static_cast<char>(p >> 8 * k & 255);
    }
  }
  for (const auto& g : gaussians) bytes += static_cast<char>(g.opacity);
  for (const auto& g : gaussians) bytes.append(g.color.begin(), g.color.end());
  for (const auto& g : gaussians) bytes.append(g.scale.begin(), g.scale.end());
  for (const auto& g : gaussians) bytes.append(g.rotation.begin(), g.rotation.begin() + (version == 2 ? 3 : 4));
  for (const auto& g : gaussians) bytes.append(g.harmonics.begin(), g.harmonics.end());
  return bytes;
}

inline std::string gzip(const std::string& bytes) {
  return deflated(bytes, kGzip);
}

}  // namespace physmas::testing

#endif
