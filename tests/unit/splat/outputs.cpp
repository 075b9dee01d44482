#include <doctest/doctest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "base/error.h"
#include "base/file.h"
#include "scene/image_file.h"
#include "splat/comparison.h"
#include "splat/depth_picture.h"
#include "splat/row_colors.h"
#include "splat/video.h"
#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::splat;
using namespace physmas::splat_test;

namespace {

void write_grey_video(const std::string& path, int width, int height, int frames, uint8_t level, double fps = 25) {
  VideoWriter writer(path, width, height, fps);
  for (int t = 0; t < frames; ++t) {
    Image image(width, height, 3);
    for (auto& p : image.pixels) p = static_cast<uint8_t>(level + 10 * t);
    writer.write(image);
  }
  writer.finish();
}

}  // namespace

TEST_CASE("splat: depth pictures hold the depth in equal levels, and 0 where nothing is drawn") {
  const TemporaryFolder folder;
  SolverMap map;
  map.s = 0.5, map.d = {1, 1, 1}, map.length = 2;  // the cube is [-2, 2]^3 in the scene
  const Camera camera = front_camera(33, 33, 4);
  const double unit = depth_unit({camera}, map);
  CHECK(unit == doctest::Approx(6.0 / 65535));
  Camera away = camera;
  away.world_to_camera(2, 3) = -50;
  CHECK(depth_unit({away}, map) == 1);
  CHECK(depth_unit({away, camera}, map) == unit);

  const Gaussians g = one_gaussian(0.05f, 0.9f, 0.5f);
  RenderOptions options;
  options.depth = true;
  Renderer renderer(g);
  const RenderedImage& image = renderer.render(camera, {}, options);
  const std::string path = folder.path() + "/depth.png";
  CHECK(save_depth_png(path, image, unit));
  CHECK_FALSE(save_depth_png(path, image, unit));
  const cv::Mat levels = cv::imread(path, cv::IMREAD_UNCHANGED);
  REQUIRE(levels.type() == CV_16UC1);
  CHECK(levels.at<uint16_t>(16, 16) == std::lround(4 / unit));
  CHECK(levels.at<uint16_t>(0, 0) == 0);
  save_depth_png(path, image, 1e-9);  // farther than the levels reach
  CHECK(cv::imread(path, cv::IMREAD_UNCHANGED).at<uint16_t>(16, 16) == 65535);
}

TEST_CASE("splat: rows have colours of their own, residual rows are grey") {
  Gaussians g = one_gaussian(0.1f, 0.9f, 0.5f);
  g.resize(3, 0);
  g.sh[1] = g.sh[2] = g.sh[0];
  const Gaussians painted = painted_by_row(g, {0, 1, 2}, {false, false, true});
  CHECK(painted.sh_degree == 0);
  CHECK((painted.sh[0] - painted.sh[1]).norm() > 0.5f);
  CHECK(painted.sh[2][0] == painted.sh[2][1]);
  CHECK(painted.sh[2][1] == painted.sh[2][2]);
}

TEST_CASE("video: a comparison shows every video in its cell, and holds the last frame of shorter ones") {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return folder.path() + "/" + name + ".mp4"; };
  write_grey_video(path("long"), 64, 48, 6, 40);
  write_grey_video(path("short"), 64, 48, 2, 150);
  write_grey_video(path("tall"), 48, 96, 6, 90);
  ComparisonOptions options;
  options.videos = {path("long"), path("short"), path("tall")};
  options.titles = {"a", "b", std::string(200, 'c')};
  options.out = path("out");
  CHECK(write_comparison(options) == 6);
  std::vector<Image> frames;
  const VideoInfo info = decode_video(options.out, [&](const Image& frame) { frames.push_back(frame); });
  CHECK(info.frames == 6);
  CHECK(info.fps == doctest::Approx(25));
  REQUIRE(frames.size() == 6);
  // Two columns of 64 pixels with gaps of 4, rows of 48 pixels and 22 for title and gap. H.264 costs a few levels.
  const auto level = [&](int t, int x, int y) { return int(frames[t].at(x, y)[1]); };
  for (int t = 0; t < 6; ++t) {
    CHECK(std::abs(level(t, 36, 28) - (40 + 10 * t)) <= 4);
    CHECK(std::abs(level(t, 104, 28) - (150 + 10 * std::min(t, 1))) <= 4);
    CHECK(std::abs(level(t, 36, 98) - (90 + 10 * t)) <= 4);
    CHECK(level(t, 8, 98) > 245);     // beside the tall one
    CHECK(level(t, 104, 98) > 245);   // no fourth
    CHECK(level(t, 110, 135) > 245);  // the long title ends with its cell
  }

  const auto code_of = [](const ComparisonOptions& bad) {
    try {
      write_comparison(bad);
    } catch (const Error& error) {
      return static_cast<int>(error.code());
    }
    return 0;
  };
  ComparisonOptions bad = options;
  bad.titles.pop_back();
  CHECK(code_of(bad) == 2);
  bad = options;
  bad.videos.resize(1), bad.titles.clear();
  CHECK(code_of(bad) == 2);
  write_grey_video(path("slow"), 64, 48, 2, 150, 10);
  bad = options;
  bad.videos[1] = path("slow");
  CHECK(code_of(bad) == 3);
}
