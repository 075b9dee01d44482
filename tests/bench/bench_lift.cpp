// Seconds of lifting and filling: 200,000 Gaussians in 20 rows, four views of 800 x 800, one tab-separated line per
// depth test and number of threads. CPU seconds are of all threads together.
// Usage: bench_lift [FOLDER]  also writes the scene there as a bundle, for pm-lift:
//   pm-lift --scene FOLDER/scene.json --inventory FOLDER/inventory.json --masks FOLDER/masks.h5 --out state.h5
#include <fmt/format.h>
#include <omp.h>

#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "bundle/synth.h"
#include "bundle/view_rig.h"
#include "bundle/views.h"
#include "lift/assignment.h"
#include "lift/initial_state.h"
#include "plan/scene_inventory.h"
#include "records/example.h"
#include "records/masks.h"
#include "records/scene.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/renderer.h"

using namespace physmas;
using Occlusion = RunSpecification::Lifting::Occlusion;

namespace {

constexpr size_t kGaussians = 200000;
constexpr int kSize = 800, kTowers = 4, kStoreys = 5;

// Four towers of five balls and boxes, every storey a part.
Example towers() {
  Example example;
  example.name = "towers";
  example.prompt = "the towers fall";
  for (int t = 0; t < kTowers; ++t) {
    ExampleObject tower;
    tower.id = tower.name = fmt::format("tower-{}", t);
    for (int s = 0; s < kStoreys; ++s) {
      ExamplePart storey;
      storey.part = storey.name = fmt::format("storey-{}", s);
      ExampleShape shape;
      shape.type = (s + t) % 2 == 0 ? ExampleShape::Type::sphere : ExampleShape::Type::box;
      shape.radius = 0.5;
      shape.size = {0.9, 0.9, 0.9};
      shape.center = {1.4 * (t % 2), 1.4 * (t / 2), 0.5 + s};
      shape.spacing = 0.018;
      shape.color = {0.2 + 0.15 * s, 0.2 + 0.2 * t, 0.9 - 0.15 * s};
      storey.shapes = {shape};
      tower.parts.push_back(storey);
    }
    example.objects.push_back(tower);
  }
  return example;
}

// Evenly thinned to kGaussians.
bundle::SynthScene thinned(const bundle::SynthScene& all) {
  const size_t n = all.gaussians.size();
  if (n < kGaussians) throw internal_error(fmt::format("{} Gaussians: the towers' spacing is too wide", n));
  bundle::SynthScene scene;
  scene.inventory = all.inventory;
  scene.gaussians.resize(kGaussians, 0);
  for (size_t i = 0; i < kGaussians; ++i) {
    const size_t from = i * n / kGaussians;
    scene.gaussians.position[i] = all.gaussians.position[from];
    scene.gaussians.log_scale[i] = all.gaussians.log_scale[from];
    scene.gaussians.rotation[i] = all.gaussians.rotation[from];
    scene.gaussians.opacity_logit[i] = all.gaussians.opacity_logit[from];
    scene.gaussians.sh[i] = all.gaussians.sh[from];
    scene.row.push_back(all.row[from]);
  }
  return scene;
}

// What each view shows of every row, and the rows' union as objects.
std::vector<ViewMasks> true_masks(const bundle::SynthScene& scene, const Inventory& inventory,
                                  const std::vector<Camera>& cameras) {
  splat::Renderer renderer(scene.gaussians);
  splat::RenderOptions options;
  options.labels = scene.row.data();
  options.label = true;
  std::vector<ViewMasks> views;
  for (size_t v = 0; v < cameras.size(); ++v) {
    const splat::RenderedImage& image = renderer.render(cameras[v], {}, options);
    const Mask none{kSize, kSize, std::vector<uint8_t>(size_t(kSize) * kSize, 0), 1, "true"};
    ViewMasks view{bundle::kViewNames[v], std::vector<Mask>(kTowers, none), std::vector<Mask>(inventory.rows.size())};
    for (size_t r = 0; r < scene.inventory.rows.size(); ++r) view.rows[r] = none;
    for (size_t p = 0; p < none.pixels.size(); ++p) {
      const int32_t r = image.label[p];
      if (r < 0) continue;
      view.rows[r].pixels[p] = 255;
      view.objects[inventory.object_of_row(r)].pixels[p] = 255;
    }
    views.push_back(std::move(view));
  }
  return views;
}

void write_bundle(const std::string& folder, const bundle::SynthScene& synth, const Inventory& inventory,
                  const std::vector<ViewMasks>& masks, Scene scene) {
  Provenance provenance;
  provenance.tool = "bench_lift";
  scene.gaussians = folder + "/gaussians.ply";
  save_gaussians_ply(scene.gaussians, synth.gaussians);
  std::vector<Camera> cameras;
  for (const SceneView& view : scene.views) cameras.push_back(view.camera);
  const std::vector<Image> images = bundle::render_view_images(synth.gaussians, cameras, scene.run.render);
  for (size_t v = 0; v < images.size(); ++v) {
    scene.views[v].image = folder + "/views/" + scene.views[v].name + ".png";
    save_png(scene.views[v].image, images[v]);
  }
  scene.inventory = folder + "/inventory.json";
  save_inventory(scene.inventory, inventory, {}, provenance);
  save_masks(folder + "/masks.h5", inventory, masks, {}, provenance);
  save_scene(folder + "/scene.json", scene, provenance);
}

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void measure(const bundle::SynthScene& synth, const Inventory& inventory, const std::vector<ViewMasks>& masks,
             const std::vector<Camera>& cameras, const RunSpecification& run, Occlusion occlusion, int threads) {
  omp_set_num_threads(threads);
  const Stopwatch watch;
  const double cpu = cpu_seconds();
  const lift::Labels labels = lift::assign_rows({synth.gaussians, cameras, masks, inventory, occlusion});
  const double lifted = watch.seconds(), lifted_cpu = cpu_seconds() - cpu;
  const State state = lift::initial_state(synth.gaussians, labels, inventory, run, "towers");
  long right = 0;
  for (size_t i = 0; i < synth.row.size(); ++i) right += labels.row[i] == synth.row[i];
  std::printf("%s\t%d\t%zu\t%ld\t%.2f\t%.2f\t%.2f\t%.2f\t%.4f\n", occlusion == Occlusion::depth ? "depth" : "none",
              threads, synth.gaussians.size(), state.particle_count(), lifted, lifted_cpu, watch.seconds() - lifted,
              cpu_seconds() - cpu - lifted_cpu, static_cast<double>(right) / static_cast<double>(synth.row.size()));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bundle::SynthScene synth = thinned(bundle::synthesize(towers(), "towers"));
    Inventory inventory = synth.inventory;
    const std::vector<std::string> names(bundle::kViewNames.begin(), bundle::kViewNames.end());
    plan::complete_inventory(inventory, names, "towers");
    const std::vector<Camera> cameras =
        bundle::view_cameras(bundle::means_of(synth.gaussians), 18, {"z", 40, 0.1, kSize, kSize});
    const std::vector<ViewMasks> masks = true_masks(synth, inventory, cameras);
    Scene scene;
    scene.name = "towers";
    scene.prompt = "the towers fall";
    scene.run.particles.max = 400000;
    scene.run.lifting.occlusion = Occlusion::depth;
    for (size_t v = 0; v < cameras.size(); ++v) scene.views.push_back({names[v], "", cameras[v]});
    scene.output_cameras = {cameras[0]};
    if (argc > 1) write_bundle(argv[1], synth, inventory, masks, scene);
    std::printf(
        "depth test\tthreads\tGaussians\tparticles\tlifting s\tits CPU s\tfilling s\tits CPU s\trow accuracy\n");
    for (const Occlusion occlusion : {Occlusion::none, Occlusion::depth}) {
      for (const int threads : {1, 2}) measure(synth, inventory, masks, cameras, scene.run, occlusion, threads);
    }
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_lift: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
