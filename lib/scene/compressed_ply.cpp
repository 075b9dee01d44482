#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr size_t kChunkRows = 256;

struct Chunk {
  double min_position[3], max_position[3];
  double min_scale[3], max_scale[3];  // of log scale
  double min_color[3] = {0, 0, 0}, max_color[3] = {1, 1, 1};
};

double unorm(uint32_t word, int shift, int bits) {
  const uint32_t mask = (1u << bits) - 1;
  return static_cast<double>((word >> shift) & mask) / mask;
}

float lerp(double a, double b, double t) {
  return static_cast<float>(a * (1 - t) + b * t);
}

// x, y, z in 11, 10 and 11 bits from the top, within per-axis bounds.
Eigen::Vector3f unpack_11_10_11(uint32_t word, const double* low, const double* high) {
  return {lerp(low[0], high[0], unorm(word, 21, 11)), lerp(low[1], high[1], unorm(word, 11, 10)),
          lerp(low[2], high[2], unorm(word, 0, 11))};
}

// Two bits tell which of w, x, y, z is the largest (left out); the others take ten bits each within +-1/sqrt(2).
std::array<float, 4> unpack_smallest_three(uint32_t word) {
  const double small[3] = {(unorm(word, 20, 10) - 0.5) * std::sqrt(2.0), (unorm(word, 10, 10) - 0.5) * std::sqrt(2.0),
                           (unorm(word, 0, 10) - 0.5) * std::sqrt(2.0)};
  const double rest = 1 - small[0] * small[0] - small[1] * small[1] - small[2] * small[2];
  const uint32_t largest = word >> 30;
  std::array<float, 4> q;
  int next = 0;
  for (uint32_t k = 0; k < 4; ++k) {
    q[k] = static_cast<float>(k == largest ? std::sqrt(std::max(0.0, rest)) : small[next++]);
  }
  return q;
}

// Positions of `names` in `element`, all of them of the given type.
std::vector<int> columns(const PlyFile& file, const PlyElement& element, const std::vector<std::string>& names,
                         PlyType type, const char* type_name) {
  std::vector<int> found;
  for (const std::string& name : names) {
    const int index = element.find(name);
    if (index < 0) throw invalid_input({file.path(), "element " + element.name, "no property " + name, type_name});
    const PlyProperty& property = element.properties[index];
    if (property.type != type || property.is_list) {
      throw invalid_input({file.path(), "element " + element.name + " property " + name, "another type", type_name});
    }
    found.push_back(index);
  }
  return found;
}

std::vector<Chunk> read_chunks(const PlyFile& file, const PlyElement& element) {
  std::vector<std::string> names;
  for (const char* name : {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y",
                           "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"}) {
    names.push_back(name);
  }
  // Files before SuperSplat 2 have no colour bounds: colours then lie within 0..1.
  const bool has_color = element.find("min_r") >= 0;
  if (has_color) names.insert(names.end(), {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"});
  const std::vector<int> wanted = columns(file, element, names, PlyType::float32, "float");
  std::vector<Chunk> chunks(element.count);
  file.read_rows(element, wanted, [&](size_t i, const double* v) {
    for (size_t k = 0; k < wanted.size(); ++k) {
      if (std::isfinite(v[k])) continue;
      throw invalid_input({file.path(), fmt::format("element chunk row {} property {}", i, names[k]),
                           fmt::format("{}", v[k]), "a finite number"});
    }
    for (int a = 0; a < 3; ++a) {
      Chunk& c = chunks[i];
      c.min_position[a] = v[a], c.max_position[a] = v[3 + a];
      c.min_scale[a] = v[6 + a], c.max_scale[a] = v[9 + a];
      if (has_color) c.min_color[a] = v[12 + a], c.max_color[a] = v[15 + a];
    }
  });
  return chunks;
}

// Degree by the number of f_rest_* columns of an `sh` element.
int sh_degree_of(const PlyFile& file, const PlyElement& sh) {
  for (int degree = 1; degree <= 3; ++degree) {
    if (sh.properties.size() == 3u * (sh_coefficient_count(degree) - 1)) return degree;
  }
  throw invalid_input({file.path(), "element sh", fmt::format("{} properties", sh.properties.size()), "9, 24 or 45"});
}

}  // namespace

bool is_compressed_ply(const PlyFile& file) {
  const PlyElement* vertex = file.find("vertex");
  return vertex != nullptr && vertex->find("packed_position") >= 0;
}

Gaussians read_compressed_ply(const PlyFile& file) {
  const PlyElement& vertex = *file.find("vertex");
  const PlyElement* chunk = file.find("chunk");
  const PlyElement* sh = file.find("sh");
  if (vertex.count == 0) throw invalid_input({file.path(), "element vertex", "no Gaussians", "at least one"});
  const uint64_t expected_chunks = (vertex.count + kChunkRows - 1) / kChunkRows;
  if (chunk == nullptr || chunk->count != expected_chunks) {
    throw invalid_input({file.path(), "element chunk", fmt::format("{} rows", chunk ? chunk->count : 0),
                         fmt::format("{} for {} Gaussians", expected_chunks, vertex.count)});
  }
  if (sh != nullptr && sh->count != vertex.count) {
    throw invalid_input({file.path(), "element sh", fmt::format("{} rows", sh->count),
                         fmt::format("{}, one per Gaussian", vertex.count)});
  }
  const int degree = sh != nullptr ? sh_degree_of(file, *sh) : 0;
  const int rest = sh_coefficient_count(degree) - 1;
  const std::vector<int> packed = columns(
      file, vertex, {"packed_position", "packed_rotation", "packed_scale", "packed_color"}, PlyType::uint32, "uint");
  for (const PlyProperty& property : vertex.properties) {
    if (property.is_list) {
      throw invalid_input({file.path(), "element vertex property " + property.name, "a list", "plain numbers"});
    }
  }
  const std::vector<Chunk> chunks = read_chunks(file, *chunk);

  Gaussians g;
  g.resize(vertex.count, degree);
  file.read_rows(vertex, packed, [&](size_t i, const double* v) {
    const Chunk& c = chunks[i / kChunkRows];
    const auto word = [v](int k) { return static_cast<uint32_t>(v[k]); };
    g.position[i] = unpack_11_10_11(word(0), c.min_position, c.max_position);
    g.rotation[i] = unpack_smallest_three(word(1));
    g.log_scale[i] = unpack_11_10_11(word(2), c.min_scale, c.max_scale);
    for (int a = 0; a < 3; ++a) {
      const double t = unorm(word(3), 24 - 8 * a, 8);
      g.sh[i * (rest + 1)][a] = sh_of_color(c.min_color[a] * (1 - t) + c.max_color[a] * t);
    }
    g.opacity_logit[i] = opacity_logit_of((word(3) & 0xff) / 255.0);
  });
  if (sh != nullptr) {
    std::vector<std::string> names;
    for (int k = 0; k < 3 * rest; ++k) names.push_back(fmt::format("f_rest_{}", k));
    file.read_rows(*sh, columns(file, *sh, names, PlyType::uint8, "uchar"), [&](size_t i, const double* v) {
      for (int channel = 0; channel < 3; ++channel) {
        for (int k = 0; k < rest; ++k) {
          // The bytes quantise -4..4; inner codes stand for the middle of their interval.
          const double byte = v[channel * rest + k];
          const double t = byte == 0 ? 0 : byte == 255 ? 1 : (byte + 0.5) / 256;
          g.sh[i * (rest + 1) + 1 + k][channel] = static_cast<float>((t - 0.5) * 8);
        }
      }
    });
  }
  return g;
}

}  // namespace physmas
