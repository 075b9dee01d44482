#include "bundle/synth_bundle.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/log.h"
#include "bundle/color_hints.h"
#include "bundle/synth.h"
#include "bundle/view_rig.h"
#include "bundle/views.h"
#include "records/example.h"
#include "records/json.h"
#include "records/scene.h"
#include "records/truth.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "scene/placement.h"
#include "splat/renderer.h"

namespace physmas::bundle {
namespace {

// The example's run block with the example's up axis and floor.
RunSpecification run_for(const Example& example, const Gaussians& gaussians, const std::string& file) {
  Json json = example.run;
  if (json.value("/placement/up"_json_pointer, example.up) != example.up) {
    throw invalid_field(file, "/run/placement/up", json["placement"]["up"],
                        "the example's own /up, \"" + example.up + "\"");
  }
  json["placement"]["up"] = example.up;
  const RunSpecification run = run_specification_from(json, file, "/run");
  if (!example.floor) return run;
  const SolverMap map = solver_map(gaussians, run);
  const double height = map.s * example.floor->height + run.placement.up_vector().dot(map.d);
  if (height < wall_heights(run).lowest) {
    throw invalid_field(
        file, "/floor/height", example.floor->height,
        fmt::format("a floor above the lower wall of the solver's cube, at height {:.3f} in scene units",
                    (wall_heights(run).lowest - run.placement.up_vector().dot(map.d)) / map.s),
        "raise run.placement.center or make run.placement.extent smaller");
  }
  const RunSpecification::Collider plane = floor_at(height, run);
  json["colliders"].push_back({{"type", "plane"},
                               {"point", to_json(plane.point)},
                               {"normal", to_json(plane.normal)},
                               {"mode", example.floor->mode},
                               {"friction", example.floor->friction}});
  return run_specification_from(json, file, "/run");
}

// What the output camera must see: the scene, the scene after falling to the floor, and the box that the author asks
// for.
std::vector<Eigen::Vector3d> points_to_frame(const Example& example, const Gaussians& gaussians) {
  const Eigen::Matrix3d axes = scene_axes(example.up);
  const Eigen::Vector3d up = axes.col(2);
  std::vector<Eigen::Vector3d> points = means_of(gaussians);
  if (example.floor) {
    double lowest = up.dot(points.front());
    for (const Eigen::Vector3d& p : points) lowest = std::min(lowest, up.dot(p));
    const size_t count = points.size();
    for (size_t i = 0; i < count; ++i) points.push_back(points[i] + (example.floor->height - lowest) * up);
  }
  for (const Eigen::Vector3d& corner : example.camera.frame) points.push_back(axes * corner);
  return points;
}

void write_true_masks(const SynthScene& synth, const std::vector<SceneView>& views, const std::string& folder) {
  splat::Renderer renderer(synth.gaussians);
  splat::RenderOptions options;
  options.max_sh_degree = 0;
  options.labels = synth.row.data();
  options.label = true;
  for (const SceneView& view : views) {
    const splat::RenderedImage& image = renderer.render(view.camera, {}, options);
    for (size_t r = 0; r < synth.inventory.rows.size(); ++r) {
      Image mask(image.width, image.height, 1);
      for (size_t p = 0; p < mask.pixels.size(); ++p)
        mask.pixels[p] = image.label[p] == static_cast<int32_t>(r) ? 255 : 0;
      save_png(folder + "/" + view.name + "/" + synth.inventory.rows[r].key() + ".png", mask);
    }
  }
}

}  // namespace

void write_synth_bundle(const std::string& example_path, const std::string& folder, bool masks) {
  const Example example = load_example(example_path);
  SynthScene synth = synthesize(example, example_path);
  Scene scene;
  scene.name = example.name;
  scene.prompt = example.prompt;
  scene.run = run_for(example, synth.gaussians, example_path);
  scene.gaussians = folder + "/gaussians.ply";
  scene.inventory = folder + "/inventory.json";

  const std::vector<Camera> cameras = view_cameras(means_of(synth.gaussians), example.camera.view_elevation,
                                                   {example.up, kViewFov, kViewMargin, kViewSize, kViewSize});
  const std::vector<Image> images = render_view_images(synth.gaussians, cameras, scene.run.render);
  add_color_hints(synth.gaussians, synth.row, cameras, scene.run.render, synth.inventory);
  scene.output_cameras = {frame_points(
      points_to_frame(example, synth.gaussians), {example.camera.azimuth, example.camera.elevation},
      {example.up, example.camera.fov, example.camera.margin, scene.run.render.width, scene.run.render.height})};
  Provenance provenance;
  provenance.tool = "pm-scene";
  provenance.options = {{"command", "synth"}};
  provenance.add_input(example_path);

  save_gaussians_ply(scene.gaussians, synth.gaussians);
  for (size_t i = 0; i < images.size(); ++i) {
    scene.views.push_back({kViewNames[i], folder + "/views/" + kViewNames[i] + ".png", cameras[i]});
    save_png(scene.views.back().image, images[i]);
  }
  save_inventory(scene.inventory, synth.inventory, {}, provenance);
  save_truth(folder + "/truth.h5", synth.row, provenance);
  if (masks) write_true_masks(synth, scene.views, folder + "/true-masks");
  save_scene(folder + "/scene.json", scene, provenance);
  log_info(fmt::format("{}: {} Gaussians in {} rows", folder, synth.gaussians.size(), synth.inventory.rows.size()));
}

}  // namespace physmas::bundle
