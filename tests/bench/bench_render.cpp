// Milliseconds per frame of the renderer by phase, one tab-separated line per scene: 50 frames of 800 x 800 in which
// every Gaussian moves, as pm-render makes them, and the H.264 video. Run from the project's folder.
// Usage: bench_render [FILE ...]  more files of Gaussians, y down
#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "records/example.h"
#include "scene/gaussian_files.h"
#include "scene/synth.h"
#include "scene/view_rig.h"
#include "splat/image_io.h"
#include "splat/renderer.h"
#include "splat/video.h"

using namespace physmas;
using namespace physmas::splat;
namespace fs = std::filesystem;

namespace {

constexpr int kSize = 800, kFrames = 50;

// Gaussian i sways, each a little differently.
struct Sway {
  std::vector<Eigen::Vector3f> position;
  std::vector<RowMatrix3f> F;
  void set(const Gaussians& g, int frame, float size) {
    position.resize(g.size());
    F.resize(g.size());
    for (size_t i = 0; i < g.size(); ++i) {
      const float angle = 0.01f * static_cast<float>(frame + 1) * (1 + 1e-3f * static_cast<float>(i % 97));
      F[i] = Eigen::AngleAxisf(angle, Eigen::Vector3f(0.48f, 0.6f, 0.64f)).toRotationMatrix();
      F[i](0, 1) += 0.3f * angle;
      position[i] = g.position[i] + 0.05f * size * angle * Eigen::Vector3f(1, 0.5f, 0.25f);
    }
  }
};

void report(const std::string& name, const Gaussians& g, const std::string& up) {
  const Camera camera = frame_points(robust_means_of(g), {25, 15}, {up, 40, 0.12, kSize, kSize});
  const std::string path = (fs::temp_directory_path() / fmt::format("physmas-bench-{}.mp4", getpid())).string();
  Renderer renderer(g);
  RenderOptions options;
  options.background.setOnes();
  Sway sway;
  RenderStats sum;
  double quantise = 0, encode = 0, still = 0;
  VideoWriter video(path, kSize, kSize, 25);
  for (int frame = -1; frame < kFrames; ++frame) {
    sway.set(g, frame, static_cast<float>(100 * renderer.default_near()));
    const RenderedImage& image = renderer.render(camera, {sway.position.data(), sway.F.data()}, options);
    if (frame < 0) continue;  // warms up caches and pages
    sum.project_seconds += renderer.stats().project_seconds;
    sum.sort_seconds += renderer.stats().sort_seconds;
    sum.bin_seconds += renderer.stats().bin_seconds;
    sum.raster_seconds += renderer.stats().raster_seconds;
    sum.pairs += renderer.stats().pairs;
    const Stopwatch quantise_watch;
    const Image picture = quantize(image);
    quantise += quantise_watch.seconds();
    const Stopwatch encode_watch;
    video.write(picture);
    encode += encode_watch.seconds();
    const Stopwatch still_watch;
    renderer.render(camera, {sway.position.data(), sway.F.data()}, options);
    still += still_watch.seconds();
  }
  const Stopwatch finish_watch;
  video.finish();
  encode += finish_watch.seconds();
  fs::remove(path);
  const double render = sum.project_seconds + sum.sort_seconds + sum.bin_seconds + sum.raster_seconds;
  const auto ms = [](double seconds) { return 1e3 * seconds / kFrames; };
  std::printf("%s\t%zu\t%d\t%zu\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.2f\t%.0f\n", name.c_str(), g.size(),
              g.sh_degree, sum.pairs / kFrames, ms(sum.project_seconds), ms(sum.sort_seconds), ms(sum.bin_seconds),
              ms(sum.raster_seconds), ms(render), ms(still), ms(quantise), ms(encode), render + quantise + encode,
              static_cast<double>(peak_memory_bytes()) / (1 << 20));
  std::fflush(stdout);
}

// Captured scenes have about this spread of sizes, opacities and colours.
Gaussians million() {
  Gaussians g;
  g.resize(1000000, 3);
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  for (size_t i = 0; i < g.size(); ++i) {
    g.position[i] = {normal(random), normal(random), normal(random)};
    for (int a = 0; a < 3; ++a) g.log_scale[i][a] = -5 + 0.7f * normal(random);
    for (float& q : g.rotation[i]) q = normal(random);
    g.opacity_logit[i] = 2 * normal(random);
    Eigen::Vector3f* sh = &g.sh[16 * i];
    for (int k = 0; k < 16; ++k) sh[k] = (k == 0 ? 1.0f : 0.1f) * Eigen::Vector3f(normal(random), normal(random), 0);
  }
  return g;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> files = {"../shared/data/guitar.compressed.ply"};
  for (int i = 1; i < argc; ++i) files.emplace_back(argv[i]);
  std::printf(
      "scene\tGaussians\tSH degree\tsplat-tile pairs\tproject ms\tsort ms\tbin ms\traster ms\tframe ms\tstill frame ms\t"
      "quantise ms\tencode ms\t50 frames and video s\tpeak MiB so far\n");
  try {
    const std::string cake = "examples/cake.json";
    const Example example = load_example(cake);
    report("demo", synthesize(example, cake).gaussians, example.up);
    for (const std::string& file : files) {
      if (fs::exists(file)) {
        report(fs::path(file).stem().stem().string(), load_gaussians(file), "-y");
      } else {
        std::printf("%s is not there: skipped\n", file.c_str());
      }
    }
    report("a million", million(), "z");
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_render: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
