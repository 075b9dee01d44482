#include "splat/renderer.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/clock.h"
#include "base/error.h"
#include "splat/middle_box.h"
#include "splat/raster.h"

namespace physmas::splat {
namespace {

constexpr double kMaxPixels = 1 << 28;
constexpr int kMaxLabels = 4096;  // a tile's weights are kept per label: 1 KiB each

void check_camera(const Camera& camera) {
  const auto bad = [](const std::string& field, const std::string& found, const std::string& expected) {
    return invalid_input({"", "camera/" + field, found, expected});
  };
  if (camera.width <= 0 || camera.height <= 0 || double(camera.width) * camera.height > kMaxPixels) {
    throw bad("width,height", fmt::format("{} x {}", camera.width, camera.height), "1 to 2^28 pixels");
  }
  for (double f : {camera.fx, camera.fy}) {
    if (!(f > 0) || !std::isfinite(f)) throw bad("fx,fy", fmt::format("{}", f), "a positive focal length in pixels");
  }
  if (!std::isfinite(camera.cx) || !std::isfinite(camera.cy)) throw bad("cx,cy", "no finite number", "pixels");
  if (!camera.world_to_camera.allFinite())
    throw bad("world_to_camera", "an entry that is not finite", "a rigid motion");
}

double scene_size(const Gaussians& g) {
  if (g.size() == 0) return 1;
  const Eigen::Vector3d extent = middle_box(g).sizes();
  std::vector<float> values(g.size());
  // Few or coinciding Gaussians still have the size of a typical one.
  for (size_t i = 0; i < g.size(); ++i) values[i] = g.log_scale[i].maxCoeff();
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(0.5 * (values.size() - 1));
  std::nth_element(values.begin(), median, values.end());
  const double size = extent.norm() + 2 * std::exp(std::clamp<double>(*median, -60.0, 60.0));
  return std::isfinite(size) ? size : 1;
}

bool same_bits(const void* a, const void* b, size_t bytes) {
  return std::memcmp(a, b, bytes) == 0;
}

}  // namespace

Renderer::Renderer(const Gaussians& gaussians) : gaussians_(gaussians), default_near_(0.01 * scene_size(gaussians)) {
  const size_t n = gaussians.size();
  if (n > std::numeric_limits<uint32_t>::max()) throw internal_error("more than 2^32 Gaussians to render");
  splats_.resize(n);
  depth_key_.resize(n);
}

void Renderer::project(const Camera& camera, const Deformation& deformation, const RenderOptions& options,
                       int threads) {
  ProjectionSetup setup;
  setup.camera = camera;
  setup.near = options.near > 0 ? options.near : default_near_;
  setup.sh_degree = std::min(gaussians_.sh_degree, std::clamp(options.max_sh_degree, 0, 3));
  // At rest nothing is kept but that it was at rest: a large scene that is only looked at costs that much less memory.
  const bool moves = deformation.position != nullptr || deformation.F != nullptr;
  if (moves && last_position_.empty()) {
    last_position_ = gaussians_.position;
    last_F_.assign(gaussians_.size(), RowMatrix3f::Identity());
    rest_.resize(gaussians_.size());
#pragma omp parallel for num_threads(threads)
    for (size_t i = 0; i < rest_.size(); ++i) rest_[i] = rest_shape(gaussians_, i);
  }
  const bool compare = !last_position_.empty();
  const bool reuse = have_setup_ && setup == setup_;
  setup_ = setup;
  have_setup_ = true;
  const RowMatrix3f rest_F = RowMatrix3f::Identity();
  const long n = static_cast<long>(gaussians_.size());
  long skipped = 0, reprojected = 0;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1024) reduction(+ : skipped, reprojected)
  for (long i = 0; i < n; ++i) {
    const Eigen::Vector3f& position = deformation.position ? deformation.position[i] : gaussians_.position[i];
    const RowMatrix3f& F = deformation.F ? deformation.F[i] : rest_F;
    if (!reuse || (compare && (!same_bits(&position, &last_position_[i], sizeof(position)) ||
                               !same_bits(&F, &last_F_[i], sizeof(F))))) {
      if (compare) {
        last_position_[i] = position;
        last_F_[i] = F;
      }
      const Projection result = project_gaussian(gaussians_, i, compare ? rest_[i] : rest_shape(gaussians_, i),
                                                 position, F, setup_, &splats_[i]);
      depth_key_[i] = result == Projection::not_finite ? kKeyNotFinite : kKeyHidden;
      if (result == Projection::drawn) std::memcpy(&depth_key_[i], &splats_[i].depth, sizeof(uint32_t));
      ++reprojected;
    }
    skipped += depth_key_[i] == kKeyNotFinite;
  }
  stats_.skipped = static_cast<size_t>(skipped);
  stats_.reprojected = static_cast<size_t>(reprojected);
}

const RenderedImage& Renderer::render(const Camera& camera, const Deformation& deformation,
                                      const RenderOptions& options) {
  check_camera(camera);
  const int threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  stats_ = {};
  Stopwatch project_watch;
  project(camera, deformation, options, threads);
  stats_.project_seconds = project_watch.seconds();

  Stopwatch sort_watch;
  order_.sort(depth_key_.data(), options.shown, gaussians_.size());
  const std::vector<uint32_t>& order = order_.front_to_back();
  stats_.drawn = order.size();
  stats_.sort_seconds = sort_watch.seconds();

  Stopwatch count_watch;
  bins_.count(splats_.data(), order, camera.width, camera.height, threads);
  stats_.pairs = bins_.pairs();
  stats_.bin_seconds = count_watch.seconds();

  const size_t pixels = size_t(camera.width) * camera.height;
  image_.width = camera.width;
  image_.height = camera.height;
  image_.rgb.resize(3 * pixels);
  image_.alpha.resize(pixels);
  image_.depth.resize(options.depth ? pixels : 0);
  image_.label.resize(options.label ? pixels : 0);
  RasterTarget target;
  target.width = camera.width;
  target.height = camera.height;
  for (int k = 0; k < 3; ++k) target.background[k] = options.background[k];
  target.rgb = image_.rgb.data();
  target.alpha = image_.alpha.data();
  if (options.depth) target.depth = image_.depth.data();
  int label_count = 0;
  if (options.label) {
    if (options.labels == nullptr) throw internal_error("a label image was asked for without labels");
    target.label = image_.label.data();
    target.gaussian_labels = options.labels;
    for (size_t i = 0; i < gaussians_.size(); ++i) label_count = std::max(label_count, options.labels[i] + 1);
    if (label_count > kMaxLabels) throw internal_error(fmt::format("{} labels to render", label_count));
  }

  for (int first = 0; first < bins_.tile_count();) {
    Stopwatch fill_watch;
    const int end = bins_.fill(first, options.max_pairs, threads);
    stats_.bin_seconds += fill_watch.seconds();
    Stopwatch raster_watch;
#pragma omp parallel num_threads(threads)
    {
      const std::unique_ptr<TileRaster> raster = make_tile_raster(label_count);
#pragma omp for schedule(dynamic, 4)
      for (int tile = first; tile < end; ++tile) {
        raster->draw(splats_.data(), bins_.begin(tile), bins_.end(tile), tile % bins_.tiles_x(), tile / bins_.tiles_x(),
                     target);
      }
    }
    stats_.raster_seconds += raster_watch.seconds();
    first = end;
  }
  return image_;
}

}  // namespace physmas::splat
