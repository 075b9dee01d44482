// Milliseconds per frame of the renderer by phase (medians), one tab-separated line per scene: 50 frames of 800 x 800
// in which every Gaussian moves, as pm-render makes them, and the H.264 video. Run from the project's folder. Usage:
// bench_render [FILE ...]  more files of Gaussians, y down
#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "bundle/synth.h"
#include "bundle/view_rig.h"
#include "records/example.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/quantize.h"
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

// Milliseconds, the median over the frames: other work on the machine then shows least.
class Phase {
 public:
  void add(double seconds) { ms_.push_back(1e3 * seconds); }
  double median() const {
    std::vector<double> sorted = ms_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }

 private:
  std::vector<double> ms_;
};

void report(const std::string& name, const Gaussians& g, const std::string& up) {
  const Camera camera = bundle::frame_points(bundle::robust_means_of(g), {25, 15}, {up, 40, 0.12, kSize, kSize});
  const std::string path = (fs::temp_directory_path() / fmt::format("physmas-bench-{}.mp4", getpid())).string();
  Renderer renderer(g);
  RenderOptions options;
  options.background.setOnes();
  Sway sway;
  Phase project, sort, bin, raster, whole, quantise, encode, still;
  size_t pairs = 0;
  double seconds = 0;  // of the frames and the video
  VideoWriter video(path, kSize, kSize, 25);
  for (int frame = -1; frame < kFrames; ++frame) {
    sway.set(g, frame, static_cast<float>(100 * renderer.default_near()));
    const Stopwatch render_watch;
    const RenderedImage& image = renderer.render(camera, {sway.position.data(), sway.F.data()}, options);
    if (frame < 0) continue;  // warms up caches and pages
    whole.add(render_watch.seconds());
    const RenderStats& stats = renderer.stats();
    project.add(stats.project_seconds), sort.add(stats.sort_seconds);
    bin.add(stats.bin_seconds), raster.add(stats.raster_seconds);
    pairs = stats.pairs;
    const Stopwatch quantise_watch;
    const Image picture = quantize(image);
    quantise.add(quantise_watch.seconds());
    const Stopwatch encode_watch;
    video.write(picture);
    encode.add(encode_watch.seconds());
    seconds += render_watch.seconds();
    const Stopwatch still_watch;
    renderer.render(camera, {sway.position.data(), sway.F.data()}, options);
    still.add(still_watch.seconds());
  }
  const Stopwatch finish_watch;
  video.finish();
  seconds += finish_watch.seconds();
  fs::remove(path);
  std::printf("%s\t%zu\t%d\t%zu\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.1f\t%.2f\t%.0f\n", name.c_str(), g.size(),
              g.sh_degree, pairs, project.median(), sort.median(), bin.median(), raster.median(), whole.median(),
              still.median(), quantise.median(), encode.median(), seconds,
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
      "scene\tGaussians\tSH degree\tsplat-tile pairs\tproject ms\tsort ms\tbin ms\traster ms\tframe ms\tstill frame "
      "ms\t"
      "quantise ms\tencode ms\t50 frames and video s\tpeak MiB so far\n");
  try {
    const std::string cake = "examples/cake.json";
    const Example example = load_example(cake);
    report("demo", bundle::synthesize(example, cake).gaussians, example.up);
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
