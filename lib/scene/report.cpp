#include "scene/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "records/inventory.h"
#include "scene/gaussian_files.h"
#include "scene/scene.h"

namespace physmas {
namespace {

struct Summary {
  double least, median, most;
};

Summary summary_of(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 2], values.back()};
}

void print_gaussians(const std::string& path) {
  const Gaussians gaussians = load_gaussians(path);
  std::vector<float> opacities, scales;
  Eigen::Vector3f low = gaussians.position[0], high = low;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    opacities.push_back(gaussians.opacity(i));
    for (int axis = 0; axis < 3; ++axis) scales.push_back(gaussians.scale(i)[axis]);
    low = low.cwiseMin(gaussians.position[i]);
    high = high.cwiseMax(gaussians.position[i]);
  }
  const Summary opacity = summary_of(std::move(opacities)), scale = summary_of(std::move(scales));
  fmt::print("{}: {} Gaussians\n", path, gaussians.size());
  fmt::print("  spherical harmonics  degree {}\n", gaussians.sh_degree);
  fmt::print("  bounds of the means  {:.4g} {:.4g} {:.4g} to {:.4g} {:.4g} {:.4g}\n", low.x(), low.y(), low.z(),
             high.x(), high.y(), high.z());
  fmt::print("  opacity              {:.3g} to {:.3g}, median {:.3g}\n", opacity.least, opacity.most, opacity.median);
  fmt::print("  scale                {:.3g} to {:.3g}, median {:.3g}\n", scale.least, scale.most, scale.median);
}

void print_scene(const std::string& path) {
  const Scene scene = load_scene(path, {});
  const std::string slice = scene.slice.empty() ? "" : fmt::format(" (slice for {})", scene.slice);
  fmt::print("{}: scene {}{}\n", path, scene.name, slice);
  if (!scene.prompt.empty()) fmt::print("  prompt    {}\n", scene.prompt);
  for (const SceneView& view : scene.views)
    fmt::print("  view      {} {} x {}\n", view.name, view.camera.width, view.camera.height);
  fmt::print("  cameras   {} for {} frames\n", scene.output_cameras.size(), scene.run.time.frames);
  const RunSpecification& run = scene.run;
  fmt::print("  grid      {} cells of {:.4g}, up {}, {} colliders\n", run.grid.n, run.grid.dx(), run.placement.up,
             run.colliders.size());
  if (!scene.inventory.empty()) {
    for (const InventoryRow& row : load_inventory(scene.inventory).rows) fmt::print("  row       {}\n", row.key());
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
  std::fflush(stdout);
}

}  // namespace physmas
