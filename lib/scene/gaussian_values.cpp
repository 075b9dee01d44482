// What is asked of the values of every file of Gaussians.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr double kFewBroken = 0.01;  // of all Gaussians: dropped without being asked

struct Fault {
  std::string field, found, expected;
};

// What keeps Gaussian i from being drawn; empty `field`: nothing does.
Fault fault_of(const Gaussians& g, size_t i) {
  const auto bad = [](const std::string& name, float value) {
    return Fault{"property " + name, fmt::format("{}", value), "a finite number"};
  };
  static const char* const kAxis[] = {"x", "y", "z"};
  for (int a = 0; a < 3; ++a) {
    if (!std::isfinite(g.position[i][a])) return bad(kAxis[a], g.position[i][a]);
  }
  for (int a = 0; a < 3; ++a) {
    if (!std::isfinite(g.log_scale[i][a])) return bad(fmt::format("scale_{}", a), g.log_scale[i][a]);
  }
  for (int a = 0; a < 4; ++a) {
    if (!std::isfinite(g.rotation[i][a])) return bad(fmt::format("rot_{}", a), g.rotation[i][a]);
  }
  // Infinite where a converter took the logarithm of an opacity of 0 or 1, which is what it means.
  if (std::isnan(g.opacity_logit[i])) return bad("opacity", g.opacity_logit[i]);
  const Eigen::Vector3f* sh = g.sh_of(i);
  const int count = sh_coefficient_count(g.sh_degree);
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(sh[0][c])) return bad(fmt::format("f_dc_{}", c), sh[0][c]);
  }
  for (int c = 0; c < 3; ++c) {
    for (int k = 1; k < count; ++k) {
      if (!std::isfinite(sh[k][c])) return bad(fmt::format("f_rest_{}", c * (count - 1) + k - 1), sh[k][c]);
    }
  }
  float squared = 0;
  for (const float q : g.rotation[i]) squared += q * q;
  if (!(squared >= std::numeric_limits<float>::min()) || !std::isfinite(squared)) {
    return {"properties rot_0..3", fmt::format("a quaternion of length {:g}", std::sqrt(squared)), "a length near 1"};
  }
  return {};
}

void move_gaussian(Gaussians& g, size_t from, size_t to) {
  const size_t count = sh_coefficient_count(g.sh_degree);
  g.position[to] = g.position[from];
  g.log_scale[to] = g.log_scale[from];
  g.rotation[to] = g.rotation[from];
  g.opacity_logit[to] = g.opacity_logit[from];
  std::copy_n(&g.sh[from * count], count, &g.sh[to * count]);
}

}  // namespace

float opacity_logit_of(double opacity) {
  const double a = std::min(std::max(opacity, 1e-6), 1 - 1e-6);
  return static_cast<float>(std::log(a / (1 - a)));
}

float sh_of_color(double color) {
  return static_cast<float>((color - 0.5) / kShC0);
}

void mirror_z(Gaussians& g) {
  // A real harmonic of degree l and order m changes its sign with z where l + m is odd.
  const int count = sh_coefficient_count(g.sh_degree);
  for (size_t i = 0; i < g.size(); ++i) {
    g.position[i].z() *= -1;
    g.rotation[i][1] *= -1;
    g.rotation[i][2] *= -1;
    for (int l = 1, k = 1; l <= g.sh_degree; ++l) {
      for (int m = -l; m <= l; ++m, ++k) {
        if ((l + m) % 2 != 0) g.sh[i * count + k] *= -1;
      }
    }
  }
}

void sweep_values(const std::string& path, const std::string& unit, const ReadingOptions& options, bool strict,
                  GaussianFile& file) {
  Gaussians& g = file.gaussians;
  GaussianNotes& notes = file.notes;
  const size_t all = g.size();
  size_t kept = 0, flat = 0, first = 0;
  Fault fault;
  for (size_t i = 0; i < all; ++i) {
    bool thin = false;
    for (int a = 0; a < 3; ++a) {
      float& scale = g.log_scale[i][a];
      if (options.linear_scales) scale = scale > 0 ? std::log(scale) : scale == 0 ? kFlatLogScale : NAN;
      if (!(std::isinf(scale) && scale < 0)) continue;
      scale = kFlatLogScale;
      thin = true;
    }
    flat += thin;
    const Fault found = fault_of(g, i);
    if (!found.field.empty()) {
      if (fault.field.empty()) first = i, fault = found;
      continue;
    }
    if (kept != i) move_gaussian(g, i, kept);
    ++kept;
  }
  const size_t broken = all - kept;
  if (flat > 0) notes.notes.push_back(fmt::format("{} Gaussians have a scale of 0 and are flat", flat));
  if (broken == 0) return;
  const bool many = static_cast<double>(broken) > kFewBroken * static_cast<double>(all);
  if (strict || kept == 0 || (many && !options.drop_broken)) {
    std::string fix;
    if (!strict && broken < all)
      fix = fmt::format("{} of {} Gaussians are such that no renderer draws them; --read drop-broken takes the others",
                        broken, all);
    throw invalid_input({path, fmt::format("{} {} {}", unit, first, fault.field), fault.found, fault.expected, fix});
  }
  g.resize(kept, g.sh_degree);
  notes.dropped = broken;
  notes.warnings.push_back(fmt::format("{} of {} Gaussians were dropped, which no renderer draws: {} {} {} is {}",
                                       broken, all, unit, first, fault.field, fault.found));
}

}  // namespace physmas
