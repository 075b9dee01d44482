#include "scene/gaussian_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr double kShC0 = 0.28209479177387814;  // the constant real spherical harmonic
constexpr size_t kSplatBytes = 32;
// Large captured scenes reach a few GiB.
constexpr size_t kMaxGaussianBytes = size_t{16} << 30;

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

float opacity_logit_of_byte(double byte) {
  const double a = std::min(std::max(byte / 255, 1e-6), 1 - 1e-6);
  return static_cast<float>(std::log(a / (1 - a)));
}

float sh_of_color(double color) {
  return static_cast<float>((color - 0.5) / kShC0);
}

void check_values(const std::string& path, const std::string& unit, const Gaussians& g) {
  const int count = sh_coefficient_count(g.sh_degree);
  for (size_t i = 0; i < g.size(); ++i) {
    const auto require = [&](float value, const char* name, int axis) {
      if (std::isfinite(value)) return;
      const std::string field = axis < 0 ? name : fmt::format("{}_{}", name, axis);
      throw invalid_input(
          {path, fmt::format("{} {} property {}", unit, i, field), fmt::format("{}", value), "a finite number"});
    };
    static const char* const kAxis[] = {"x", "y", "z"};
    for (int a = 0; a < 3; ++a) require(g.position[i][a], kAxis[a], -1);
    for (int a = 0; a < 3; ++a) require(g.log_scale[i][a], "scale", a);
    for (int a = 0; a < 4; ++a) require(g.rotation[i][a], "rot", a);
    // Infinite where a converter took the logarithm of an opacity of 0 or 1, which is what it means.
    if (!std::isinf(g.opacity_logit[i])) require(g.opacity_logit[i], "opacity", -1);
    const Eigen::Vector3f* sh = g.sh_of(i);
    for (int c = 0; c < 3; ++c) require(sh[0][c], "f_dc", c);
    for (int c = 0; c < 3; ++c) {
      for (int k = 1; k < count; ++k) require(sh[k][c], "f_rest", c * (count - 1) + k - 1);
    }
    float squared = 0;
    for (float q : g.rotation[i]) squared += q * q;
    if (!(squared >= std::numeric_limits<float>::min()) || !std::isfinite(squared)) {
      throw invalid_input({path, fmt::format("{} {} properties rot_0..3", unit, i),
                           fmt::format("a quaternion of length {:g}", std::sqrt(squared)), "a length near 1"});
    }
  }
}

Gaussians read_splat(const std::string& path, const std::string& bytes) {
  if (bytes.empty() || bytes.size() % kSplatBytes != 0) {
    throw invalid_input({path, "size", fmt::format("{} bytes", bytes.size()),
                         fmt::format("a multiple of {}, at least one Gaussian", kSplatBytes)});
  }
  Gaussians g;
  g.resize(bytes.size() / kSplatBytes, 0);
  for (size_t i = 0; i < g.size(); ++i) {
    const char* at = bytes.data() + i * kSplatBytes;
    float v[6];
    std::memcpy(v, at, sizeof(v));
    const auto* b = reinterpret_cast<const unsigned char*>(at + sizeof(v));
    g.position[i] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
      if (!(v[3 + a] >= 0) || !std::isfinite(v[3 + a])) {
        throw invalid_input({path, fmt::format("Gaussian {} scale_{} (byte {})", i, a, i * kSplatBytes + 12 + 4 * a),
                             fmt::format("{}", v[3 + a]), "a finite number, 0 or more"});
      }
      // A flat Gaussian has scale 0, whose logarithm is not finite.
      g.log_scale[i][a] = std::log(std::max(v[3 + a], std::numeric_limits<float>::min()));
      g.sh[i][a] = sh_of_color(b[a] / 255.0);
    }
    g.opacity_logit[i] = opacity_logit_of_byte(b[3]);
    for (int k = 0; k < 4; ++k) g.rotation[i][k] = (static_cast<float>(b[4 + k]) - 128) / 128;
  }
  return g;
}

Gaussians parse_gaussians(const std::string& path, const std::string& bytes) {
  if (PlyFile::is_ply(bytes)) {
    const PlyFile file(path, bytes);
    Gaussians g = is_compressed_ply(file) ? read_compressed_ply(file) : read_standard_ply(file);
    check_values(path, "element vertex row", g);
    return g;
  }
  if (is_spz(bytes)) {
    Gaussians g = read_spz(path, bytes);
    check_values(path, "Gaussian", g);
    return g;
  }
  if (ends_with(path, ".splat")) {
    Gaussians g = read_splat(path, bytes);
    check_values(path, "Gaussian", g);
    return g;
  }
  throw invalid_input({path, "byte 0", bytes.empty() ? "an empty file" : "no PLY magic",
                       "a 3DGS .ply, a SuperSplat .compressed.ply, an .spz, or a .splat file"});
}

Gaussians load_gaussians(const std::string& path) {
  return parse_gaussians(path, read_file(path, kMaxGaussianBytes));
}

Gaussians load_labelled_gaussians(const std::string& path, const State& state, const std::string& state_path) {
  Gaussians gaussians = load_gaussians(path);
  if (state.gaussian_count() != gaussians.size()) {
    throw invalid_input({state_path, "/gaussians/row", std::to_string(state.gaussian_count()) + " Gaussians",
                         "the " + std::to_string(gaussians.size()) + " of " + path,
                         "make the state again with pm-lift"});
  }
  return gaussians;
}

}  // namespace physmas
