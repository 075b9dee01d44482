#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "base/file.h"
#include "scene/gaussian_files.h"

namespace physmas {
namespace {

constexpr size_t kChunk = 256;
constexpr float kMostLogScale = 20;  // scales of the format are cut there

uint32_t level(double t, int bits) {
  const uint32_t most = (1u << bits) - 1;
  return static_cast<uint32_t>(std::clamp(std::floor(t * most + 0.5), 0.0, static_cast<double>(most)));
}

// Per axis, of one chunk.
struct Bounds {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::max());
  Eigen::Array3f high = -low;
  void take(const Eigen::Vector3f& v) {
    low = low.min(v.array());
    high = high.max(v.array());
  }
  double place(const Eigen::Vector3f& v, int axis) const {
    const double size = double(high[axis]) - low[axis];
    return size > 0 ? (double(v[axis]) - low[axis]) / size : 0;
  }
  uint32_t packed(const Eigen::Vector3f& v) const {
    return level(place(v, 0), 11) << 21 | level(place(v, 1), 10) << 11 | level(place(v, 2), 11);
  }
};

Eigen::Vector3f cut_scale(const Eigen::Vector3f& log_scale) {
  return log_scale.cwiseMax(-kMostLogScale).cwiseMin(kMostLogScale);
}

// Two bits for the largest of w, x, y, z, ten for each of the others within +-1/sqrt(2).
uint32_t packed_rotation(std::array<float, 4> q) {
  double norm = 0;
  for (const float v : q) norm += double(v) * v;
  norm = std::sqrt(norm);
  uint32_t largest = 0;
  for (uint32_t k = 1; k < 4; ++k) {
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  }
  const double sign = q[largest] < 0 ? -1 : 1;
  uint32_t word = largest;
  for (uint32_t k = 0; k < 4; ++k) {
    if (k != largest) word = word << 10 | level(sign * q[k] / norm / std::sqrt(2.0) + 0.5, 10);
  }
  return word;
}

// The bits of x, with two free places after each: one axis of a Morton code.
uint64_t spread(uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

std::vector<size_t> along_curve(const Gaussians& g) {
  Bounds bounds;
  for (const Eigen::Vector3f& p : g.position) bounds.take(p);
  std::vector<uint64_t> code(g.size());
  for (size_t i = 0; i < g.size(); ++i) {
    for (int a = 0; a < 3; ++a) code[i] |= spread(level(bounds.place(g.position[i], a), 21)) << a;
  }
  std::vector<size_t> order(g.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return code[a] < code[b]; });
  return order;
}

template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

bool save_compressed_ply(const std::string& path, const Gaussians& g) {
  const size_t n = g.size(), chunks = (n + kChunk - 1) / kChunk;
  const int rest = sh_coefficient_count(g.sh_degree) - 1;
  std::string head = "ply\nformat binary_little_endian 1.0\n";
  if (g.antialiased) head += "comment SplatRenderMode: mip\n";
  head += fmt::format("element chunk {}\n", chunks);
  for (const char* names : {"x y z", "scale_x scale_y scale_z", "r g b"}) {
    for (const char* end : {"min", "max"}) {
      std::istringstream words(names);
      for (std::string name; words >> name;) head += fmt::format("property float {}_{}\n", end, name);
    }
  }
  head += fmt::format("element vertex {}\n", n);
  for (const char* name : {"position", "rotation", "scale", "color"})
    head += fmt::format("property uint packed_{}\n", name);
  if (rest > 0) {
    head += fmt::format("element sh {}\n", n);
    for (int k = 0; k < 3 * rest; ++k) head += fmt::format("property uchar f_rest_{}\n", k);
  }
  head += "end_header\n";

  const std::vector<size_t> order = along_curve(g);
  const auto color = [&](size_t i) {
    return Eigen::Vector3f((kShC0 * g.sh_of(i)[0].cast<double>()).array().cast<float>() + 0.5f);
  };
  std::string bounds, words, harmonics;
  for (size_t first = 0; first < n; first += kChunk) {
    const size_t last = std::min(n, first + kChunk);
    Bounds position, scale, colors;
    for (size_t k = first; k < last; ++k) {
      position.take(g.position[order[k]]);
      scale.take(cut_scale(g.log_scale[order[k]]));
      colors.take(color(order[k]));
    }
    for (const Bounds* b : {&position, &scale, &colors}) {
      for (int a = 0; a < 3; ++a) put(bounds, b->low[a]);
      for (int a = 0; a < 3; ++a) put(bounds, b->high[a]);
    }
    for (size_t k = first; k < last; ++k) {
      const size_t i = order[k];
      put(words, position.packed(g.position[i]));
      put(words, packed_rotation(g.rotation[i]));
      put(words, scale.packed(cut_scale(g.log_scale[i])));
      const Eigen::Vector3f c = color(i);
      put(words, level(colors.place(c, 0), 8) << 24 | level(colors.place(c, 1), 8) << 16 |
                     level(colors.place(c, 2), 8) << 8 | level(g.opacity(i), 8));
      for (int channel = 0; channel < 3; ++channel) {
        for (int h = 1; h <= rest; ++h) {
          const double t = g.sh_of(i)[h][channel] / 8.0 + 0.5;
          harmonics += static_cast<char>(static_cast<uint8_t>(std::clamp(std::floor(t * 256), 0.0, 255.0)));
        }
      }
    }
  }
  FileWriter out(path);
  for (const std::string* part : {&head, &bounds, &words, &harmonics}) out.write(*part);
  return out.commit();
}

}  // namespace physmas
