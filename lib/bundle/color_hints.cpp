#include "bundle/color_hints.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "scene/color.h"
#include "splat/renderer.h"

namespace physmas::bundle {
namespace {

constexpr int kLevels = 32;         // per channel, of the colour histogram
constexpr double kReach = 8;        // CIELAB; a colour stands for those this near
constexpr double kCovered = 0.985;  // part of the pixels that the colours must stand for
constexpr size_t kMaxColors = 12;
constexpr double kTolerance = 18;  // CIELAB; written into the hints
constexpr int kBorder = 2;         // pixels next to another part are mixtures

using Histogram = std::map<int, long>;  // colour bin -> pixels

// Whether the (2 border + 1)^2 pixels around (x, y) all have the label of the middle.
bool is_inside(const splat::RenderedImage& image, int x, int y, int border) {
  const int32_t label = image.label[static_cast<size_t>(y) * image.width + x];
  for (int dy = -border; dy <= border; ++dy) {
    for (int dx = -border; dx <= border; ++dx) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= image.width || v >= image.height) return false;
      if (image.label[static_cast<size_t>(v) * image.width + u] != label) return false;
    }
  }
  return true;
}

void count_colors(const splat::RenderedImage& image, int border, std::vector<Histogram>& histograms) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const size_t i = static_cast<size_t>(y) * image.width + x;
      if (image.label[i] < 0 || !is_inside(image, x, y, border)) continue;
      int bin = 0;
      for (int c = 0; c < 3; ++c) {
        const double value = std::clamp(static_cast<double>(image.rgb[3 * i + c]), 0.0, 1.0);
        bin = bin * kLevels + std::min(kLevels - 1, static_cast<int>(value * kLevels));
      }
      ++histograms[image.label[i]][bin];
    }
  }
}

Eigen::Vector3d color_of(int bin) {
  // Rounded to thousandths, so that the file stays readable.
  const auto value = [](int level) { return std::nearbyint((level + 0.5) / kLevels * 1000) / 1000; };
  return {value(bin / (kLevels * kLevels)), value(bin / kLevels % kLevels), value(bin % kLevels)};
}

// Always the colour next that stands for the most pixels that none stands for yet.
std::vector<Eigen::Vector3d> covering_colors(const Histogram& histogram) {
  std::vector<Eigen::Vector3d> colors, labs;
  std::vector<long> left;
  long total = 0;
  for (const auto& [bin, pixels] : histogram) {
    colors.push_back(color_of(bin));
    labs.push_back(lab_of_srgb(colors.back()));
    left.push_back(pixels);
    total += pixels;
  }
  std::vector<Eigen::Vector3d> chosen;
  long uncovered = total;
  while (chosen.size() < kMaxColors && static_cast<double>(uncovered) > (1 - kCovered) * static_cast<double>(total)) {
    size_t best = 0;
    long best_gain = -1;
    for (size_t i = 0; i < labs.size(); ++i) {
      long gain = 0;
      for (size_t j = 0; j < labs.size(); ++j) {
        if (left[j] > 0 && (labs[i] - labs[j]).norm() < kReach) gain += left[j];
      }
      if (gain > best_gain) {
        best = i;
        best_gain = gain;
      }
    }
    chosen.push_back(colors[best]);
    for (size_t j = 0; j < labs.size(); ++j) {
      if ((labs[best] - labs[j]).norm() < kReach) {
        uncovered -= left[j];
        left[j] = 0;
      }
    }
  }
  return chosen;
}

}  // namespace

void add_color_hints(const Gaussians& gaussians, const std::vector<int32_t>& row, const std::vector<Camera>& cameras,
                     const RunSpecification::Render& render, Inventory& inventory) {
  splat::Renderer renderer(gaussians);
  splat::RenderOptions options;
  options.background = render.background.cast<float>();
  options.max_sh_degree = render.sh_degree;
  options.labels = row.data();
  options.label = true;
  std::vector<Histogram> inner(inventory.rows.size()), all(inventory.rows.size());
  for (const Camera& camera : cameras) {
    const splat::RenderedImage& image = renderer.render(camera, {}, options);
    count_colors(image, kBorder, inner);
    count_colors(image, 0, all);
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    // Thin parts are nothing but border.
    inventory.rows[r].hints.colors = covering_colors(inner[r].empty() ? all[r] : inner[r]);
    inventory.rows[r].hints.tolerance = kTolerance;
  }
}

}  // namespace physmas::bundle
