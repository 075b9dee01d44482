#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "scene/gaussian_files.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr int kLevel = 12;   // of zstd, as the format's own library has it
constexpr int kFinest = 16;  // fractional bits of positions at most: they are the same for small and moved scenes

char byte_of(double value) {
  return static_cast<char>(static_cast<uint8_t>(std::clamp(std::round(value), 0.0, 255.0)));
}

void put(std::string& bytes, uint64_t value, int count) {
  for (int k = 0; k < count; ++k) bytes += static_cast<char>(value >> 8 * k & 255);
}

// As many as 24 bits have room for.
int fractional_bits(const Gaussians& g) {
  double farthest = 0;
  for (const Eigen::Vector3f& p : g.position) farthest = std::max(farthest, double(p.cwiseAbs().maxCoeff()));
  int bits = kFinest;
  while (bits > 0 && std::ldexp(farthest, bits) > 8388606) --bits;
  return bits;
}

// The largest of x, y, z, w is left out; the others have a sign and nine bits up to 1/sqrt(2).
uint32_t packed_rotation(const std::array<float, 4>& wxyz) {
  double q[4] = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]}, norm = 0;
  for (const double v : q) norm += v * v;
  norm = std::sqrt(norm);
  int largest = 0;
  for (int k = 1; k < 4; ++k) {
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  }
  const bool turned = q[largest] < 0;
  uint32_t word = static_cast<uint32_t>(largest);
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const auto size = static_cast<uint32_t>(std::min(511.0, std::round(511 * std::abs(q[k]) / norm * std::sqrt(2.0))));
    word = word << 10 | ((q[k] < 0) != turned ? 0x200u : 0u) | size;
  }
  return word;
}

std::string packed(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size)) throw internal_error(std::string("zstd: ") + ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

}  // namespace

bool save_gaussians_spz(const std::string& path, const Gaussians& g) {
  const int bits = fractional_bits(g), rest = sh_coefficient_count(g.sh_degree) - 1;
  std::array<std::string, 6> arrays;
  auto& [positions, opacities, colors, scales, rotations, harmonics] = arrays;
  for (size_t i = 0; i < g.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      put(positions, static_cast<uint64_t>(std::llround(std::ldexp(double(g.position[i][a]), bits))), 3);
      scales += byte_of((g.log_scale[i][a] + 10.0) * 16);
      colors += byte_of((g.sh_of(i)[0][a] * kSpzColorScale + 0.5) * 255);
    }
    opacities += byte_of(g.opacity(i) * 255.0);
    put(rotations, packed_rotation(g.rotation[i]), 4);
    for (int k = 1; k <= rest; ++k) {
      for (int c = 0; c < 3; ++c) harmonics += byte_of(g.sh_of(i)[k][c] * 128.0 + 128);
    }
  }
  std::string table, streams;
  char count = 0;
  for (const std::string& array : arrays) {
    if (array.empty()) continue;  // as the format's own library does
    const std::string stream = packed(array);
    put(table, stream.size(), 8);
    put(table, array.size(), 8);
    streams += stream;
    ++count;
  }
  std::string head = "NGSP";
  put(head, 4, 4);
  put(head, g.size(), 4);
  head += {static_cast<char>(g.sh_degree), static_cast<char>(bits),
           static_cast<char>(g.antialiased ? kSpzAntialiased : 0), count};
  put(head, 32, 4);
  head.resize(32, '\0');
  FileWriter out(path);
  for (const std::string* part : {&head, &table, &streams}) out.write(*part);
  return out.commit();
}

}  // namespace physmas
