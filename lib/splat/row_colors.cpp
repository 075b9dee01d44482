#include "splat/row_colors.h"

#include <algorithm>

namespace physmas::splat {
namespace {

// Nine colours that differ in hue and lightness, after Okabe and Ito.
constexpr std::array<std::array<float, 3>, 9> kPalette = {{{0.00f, 0.45f, 0.70f},
                                                           {0.90f, 0.62f, 0.00f},
                                                           {0.00f, 0.62f, 0.45f},
                                                           {0.80f, 0.24f, 0.20f},
                                                           {0.80f, 0.47f, 0.65f},
                                                           {0.34f, 0.71f, 0.91f},
                                                           {0.94f, 0.89f, 0.26f},
                                                           {0.50f, 0.30f, 0.65f},
                                                           {0.55f, 0.40f, 0.25f}}};
constexpr std::array<float, 3> kResidual = {0.55f, 0.55f, 0.55f};
constexpr float kOwnLight = 0.35f;  // share of the scene's own lightness

}  // namespace

std::array<float, 3> row_color(int32_t row, bool residual) {
  return residual ? kResidual : kPalette[static_cast<size_t>(row) % kPalette.size()];
}

Gaussians painted_by_row(const Gaussians& gaussians, const std::vector<int32_t>& row,
                         const std::vector<bool>& residual) {
  Gaussians painted;
  painted.position = gaussians.position;
  painted.log_scale = gaussians.log_scale;
  painted.rotation = gaussians.rotation;
  painted.opacity_logit = gaussians.opacity_logit;
  painted.sh.resize(gaussians.size());
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const std::array<float, 3> color = row_color(row[i], residual[row[i]]);
    const Eigen::Vector3f own = (float(kShC0) * gaussians.sh_of(i)[0]).array() + 0.5f;
    const float light = (1 - kOwnLight) + 2 * kOwnLight * std::min(1.0f, std::max(0.0f, own.mean()));
    for (int c = 0; c < 3; ++c) painted.sh[i][c] = (color[c] * light - 0.5f) / float(kShC0);
  }
  return painted;
}

}  // namespace physmas::splat
