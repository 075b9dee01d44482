#include "bundle/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/log.h"
#include "base/output.h"
#include "bundle/dense_component.h"
#include "bundle/selection.h"
#include "records/inventory.h"
#include "records/scene.h"
#include "scene/gaussian_files.h"

namespace physmas::bundle {
namespace {

constexpr int kBins = 10, kBarWidth = 40;

// Counts of values in kBins equal parts of low..high, with bars; the last part includes its upper end.
void print_histogram(const std::vector<float>& values, double low, double high) {
  std::array<size_t, kBins> counts = {};
  for (const float value : values) {
    const double t = high > low ? (value - low) / (high - low) : 0;
    ++counts[std::clamp(static_cast<int>(t * kBins), 0, kBins - 1)];
  }
  const size_t most = *std::max_element(counts.begin(), counts.end());
  for (int bin = 0; bin < kBins; ++bin) {
    const double from = low + (high - low) * bin / kBins, to = low + (high - low) * (bin + 1) / kBins;
    const size_t bar = (counts[bin] * kBarWidth + most - 1) / most;
    print("    {:8.3g} to {:8.3g}  {:9}{}{}\n", from, to, counts[bin], bar > 0 ? "  " : "", std::string(bar, '#'));
  }
}

float median_of(std::vector<float> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void print_gaussians(const std::string& path) {
  const GaussianFile file = read_gaussian_file(path);
  const Gaussians& gaussians = file.gaussians;
  std::vector<float> opacities, scales;  // the logarithms of the scales to base 10: they span decades
  Eigen::AlignedBox3f bounds;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    opacities.push_back(gaussians.opacity(i));
    for (int axis = 0; axis < 3; ++axis)
      scales.push_back(gaussians.log_scale[i][axis] / static_cast<float>(std::log(10.0)));
    bounds.extend(gaussians.position[i]);
  }
  const auto opacity = std::minmax_element(opacities.begin(), opacities.end());
  const auto scale = std::minmax_element(scales.begin(), scales.end());
  const Eigen::Vector3f &low = bounds.min(), &high = bounds.max();
  const auto power = [](float exponent) { return std::pow(10.0, static_cast<double>(exponent)); };
  print("{}: {} Gaussians\n", path, gaussians.size());
  print("  spherical harmonics  degree {}\n", gaussians.sh_degree);
  print("  bounds of the means  {:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g}\n", low.x(), low.y(), low.z(), high.x(),
        high.y(), high.z());
  print("  opacity              {:.3g} to {:.3g}, median {:.3g}\n", *opacity.first, *opacity.second,
        median_of(opacities));
  print_histogram(opacities, 0, 1);
  print("  scale                {:.3g} to {:.3g}, median {:.3g}; by its logarithm to base 10:\n", power(*scale.first),
        power(*scale.second), power(median_of(scales)));
  print_histogram(scales, *scale.first, *scale.second);
  const Floaters floaters = find_floaters(gaussians);
  print("  floaters             {} outside {:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g}\n", floaters.count,
        floaters.box.min().x(), floaters.box.min().y(), floaters.box.min().z(), floaters.box.max().x(),
        floaters.box.max().y(), floaters.box.max().z());
  if (!file.notes.up.empty()) print("  up                   {}\n", file.notes.up);
  if (gaussians.antialiased) print("  anti-aliased         yes\n");
  for (const std::string& note : file.notes.notes) print("  note                 {}\n", note);
  for (const std::string& text : file.notes.warnings) log_warning(path + ": " + text);
  std::string warning = floater_warning(floaters, file.notes.offset);
  if (warning.empty()) warning = surroundings_warning(gaussians, dense_component(gaussians), file.notes.offset);
  if (!warning.empty()) log_warning(path + ": " + warning);
}

void print_scene(const std::string& path) {
  const Scene scene = load_scene(path, {});
  const std::string slice = scene.slice.empty() ? "" : fmt::format(" (slice for {})", scene.slice);
  print("{}: scene {}{}\n", path, one_line(scene.name), slice);
  if (!scene.prompt.empty()) print("  prompt    {}\n", one_line(scene.prompt));
  for (const SceneView& view : scene.views)
    print("  view      {} {} x {}\n", view.name, view.camera.width, view.camera.height);
  print("  cameras   {} for {} frames\n", scene.output_cameras.size(), scene.run.time.frames);
  const RunSpecification& run = scene.run;
  print("  grid      {} cells of {:.4g}, up {}, {} colliders\n", run.grid.n, run.grid.dx(), run.placement.up,
        run.colliders.size());
  if (!scene.inventory.empty()) {
    for (const InventoryRow& row : load_inventory(scene.inventory).rows) print("  row       {}\n", row.key());
  }
  if (!scene.gaussians.empty()) print_gaussians(scene.gaussians);
}

}  // namespace

void print_report(const std::string& path) {
  const size_t dot = path.rfind('.');
  if (dot != std::string::npos && path.substr(dot) == ".json") {
    print_scene(path);
  } else {
    print_gaussians(path);
  }
}

}  // namespace physmas::bundle
