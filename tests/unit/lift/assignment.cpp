#include "lift/assignment.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "lift/evidence.h"
#include "scene/neighbors.h"
#include "splat/visibility.h"

using namespace physmas;
using namespace physmas::lift;

namespace {

constexpr int kSize = 16;

// A camera that looks along +z from the origin: scene (x, y, 1) falls on pixel (x, y).
Camera pixel_camera() {
  Camera camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = 1;
  return camera;
}

// Pixels [x0, x1) x [y0, y1) inside.
Mask rectangle(int x0, int x1, int y0, int y1, double confidence = 1) {
  Mask mask;
  mask.width = mask.height = kSize;
  mask.confidence = confidence;
  mask.source = "test";
  mask.pixels.assign(kSize * kSize, 0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) mask.pixels[y * kSize + x] = 255;
  }
  return mask;
}

Gaussians gaussians_at(const std::vector<Eigen::Vector3f>& positions) {
  Gaussians g;
  g.resize(positions.size(), 0);
  g.position = positions;
  for (Eigen::Vector3f& s : g.log_scale) s.setConstant(std::log(0.1f));
  return g;
}

// One object with parts a, b and its residual row.
Inventory two_parts() {
  Inventory inventory;
  inventory.objects.resize(1);
  inventory.objects[0].id = "thing";
  for (const char* part : {"a", "b", "residual"}) {
    InventoryRow row;
    row.object = "thing";
    row.part = part;
    row.residual = std::string(part) == "residual";
    inventory.rows.push_back(row);
  }
  return inventory;
}

ViewMasks view_of(const Mask& object, const Mask& a, const Mask& b) {
  ViewMasks view;
  view.view = "front";
  view.objects = {object};
  view.rows = {a, b, Mask()};
  return view;
}

Labels lift_once(const std::vector<Eigen::Vector3f>& points, const ViewMasks& view) {
  const Gaussians g = gaussians_at(points);
  const std::vector<Camera> cameras = {pixel_camera()};
  const std::vector<ViewMasks> views = {view};
  const Inventory inventory = two_parts();
  return assign_rows({g, cameras, views, inventory});
}

}  // namespace

TEST_CASE("lift: support runs from 0.45 at the boundary to 1 at the deepest pixel, times the floored confidence") {
  // A 5 x 5 square: distances 1, 2, 3 from the edge to the middle.
  const std::vector<float> support = support_of(rectangle(4, 9, 4, 9, 0.8));
  const auto at = [&](int x, int y) { return support[y * kSize + x]; };
  CHECK(at(6, 6) == doctest::Approx(0.8));
  CHECK(at(4, 6) == doctest::Approx(0.8 * (0.45 + 0.55 / 3)));
  CHECK(at(5, 6) == doctest::Approx(0.8 * (0.45 + 0.55 * 2 / 3)));
  CHECK(at(3, 6) == 0);
  CHECK(support_of(rectangle(4, 9, 4, 9, 0.001))[6 * kSize + 6] == doctest::Approx(0.05));
  CHECK(support_of(rectangle(0, kSize, 0, kSize, 0.5))[0] == doctest::Approx(0.5 * 0.45));  // no boundary
  CHECK(support_of(Mask()).empty());
}

TEST_CASE("lift: only positive depth inside the image counts") {
  const std::vector<int32_t> pixels = splat::project_to_pixels(
      {{2.5f, 3.5f, 1}, {2.5f, 3.5f, -1}, {-0.1f, 3, 1}, {15.9f, 15.9f, 1}, {16, 3, 1}}, pixel_camera());
  CHECK(pixels == std::vector<int32_t>{3 * kSize + 2, -1, -1, 255, -1});
}

TEST_CASE("lift: the better supported row wins, and equal scores go to the smaller mask, then to the first row") {
  const Mask all = rectangle(0, kSize, 0, kSize);
  // Pixel (6, 6) is the middle of both squares: equal support, b has the smaller area.
  const Labels tie = lift_once({{6.5f, 6.5f, 1}}, view_of(all, rectangle(2, 11, 2, 11), rectangle(4, 9, 4, 9)));
  CHECK(tie.row[0] == 1);
  const Labels first = lift_once({{6.5f, 6.5f, 1}}, view_of(all, rectangle(4, 9, 4, 9), rectangle(4, 9, 4, 9)));
  CHECK(first.row[0] == 0);
  const Labels sure =
      lift_once({{6.5f, 6.5f, 1}}, view_of(all, rectangle(4, 9, 4, 9, 0.9), rectangle(4, 9, 4, 9, 0.3)));
  CHECK(sure.row[0] == 0);
  CHECK(sure.confidence[0] == doctest::Approx(0.9));
}

TEST_CASE("lift: an ambiguous Gaussian takes the vote of its reliable neighbours") {
  const Mask all = rectangle(0, kSize, 0, kSize);
  // a and b overlap in columns 6 and 7; the overlap leans to a a little, its neighbours are all b.
  const ViewMasks view = view_of(all, rectangle(0, 8, 0, kSize, 1.0), rectangle(6, kSize, 0, kSize, 0.9));
  std::vector<Eigen::Vector3f> points = {{7.5f, 8.5f, 1}};
  for (int y = 0; y < 12; ++y) points.push_back({8.6f, 3.f + y, 1});
  const Labels alone = lift_once({points[0]}, view);
  const Labels voted = lift_once(points, view);
  CHECK(alone.row[0] == 0);
  CHECK(alone.confidence[0] > 0.4f);
  CHECK(voted.confidence[0] == 0.2f);  // what neighbours say is no evidence of its own
  CHECK(voted.counts.part_votes == 1);
  CHECK(voted.row[0] == 1);
  // Which row comes first does not matter.
  const ViewMasks turned = view_of(all, rectangle(6, kSize, 0, kSize, 0.9), rectangle(0, 8, 0, kSize, 1.0));
  CHECK(lift_once({points[0]}, turned).row[0] == 1);
  CHECK(lift_once(points, turned).row[0] == 0);
  CHECK(lift_once(points, turned).confidence == voted.confidence);
}

TEST_CASE("lift: what no mask supports is residual, apart from the rescue target") {
  const Mask all = rectangle(0, kSize, 0, kSize), left = rectangle(0, 4, 0, kSize);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 40; ++i) points.push_back({2.0f + 0.01f * i, 8, 1});
  // 100 Gaussians outside a's mask, each farther than the one before.
  for (int i = 0; i < 100; ++i) points.push_back({8.0f + 0.05f * i, 8, 1});
  const Labels labels = lift_once(points, view_of(all, left, Mask()));
  CHECK(labels.counts.rescued == 64);
  CHECK(labels.counts.residual == 36);
  for (int i = 0; i < 40; ++i) CHECK(labels.row[i] == 0);
  for (int i = 40; i < 104; ++i) CHECK(labels.row[i] == 0);
  for (int i = 104; i < 140; ++i) CHECK(labels.row[i] == 2);
  for (int i = 40; i < 140; ++i) CHECK(labels.confidence[i] <= 0.20f);
  CHECK(labels.confidence[0] > 0.4f);
}

TEST_CASE("lift: a Gaussian in no view is residual of the nearest object") {
  const Mask all = rectangle(0, kSize, 0, kSize);
  std::vector<Eigen::Vector3f> points(20, Eigen::Vector3f(8, 8, 1));
  for (int i = 0; i < 200; ++i) points.push_back({8, 8, -5});
  const Labels labels = lift_once(points, view_of(all, all, Mask()));
  CHECK(labels.counts.unseen == 200);
  CHECK(labels.counts.residual == 200 - 64);
}

TEST_CASE("lift: rescue target") {
  CHECK(rescue_target(10, 1000) == 10);
  CHECK(rescue_target(1000, 1000) == 64);
  CHECK(rescue_target(1000, 100000) == 300);
  CHECK(rescue_target(1000, 100167) == 301);  // 300.501
  CHECK(rescue_target(1000, 100166) == 300);  // 300.498
}

TEST_CASE("lift: identically named parts of two objects stay apart") {
  Inventory inventory = two_parts();
  inventory.objects.push_back(inventory.objects[0]);
  inventory.objects[1].id = "other";
  for (int r = 0; r < 3; ++r) {
    inventory.rows.push_back(inventory.rows[r]);
    inventory.rows.back().object = "other";
  }
  const Mask left = rectangle(0, 8, 0, kSize), right = rectangle(8, kSize, 0, kSize);
  ViewMasks view;
  view.objects = {left, right};
  view.rows = {left, Mask(), Mask(), right, Mask(), Mask()};
  const Gaussians g = gaussians_at({{2, 8, 1}, {3, 8, 1}, {12, 8, 1}, {13, 8, 1}});
  const std::vector<Camera> cameras = {pixel_camera()};
  const std::vector<ViewMasks> views = {view};
  const Labels labels = assign_rows({g, cameras, views, inventory});
  CHECK(labels.row == std::vector<int32_t>{0, 0, 3, 3});
  CHECK(labels.object == std::vector<int32_t>{0, 0, 1, 1});
}

TEST_CASE("lift: the depth test keeps what lies behind from taking the front's row") {
  // Mask a covers the front sheet's left half, mask b its right half; a sheet behind, of b's colour, is hidden.
  Gaussians g;
  g.resize(0, 0);
  std::vector<Eigen::Vector3f> points;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 30; ++x) points.push_back({0.3f + 0.5f * x, 0.3f + 0.5f * y, 1});
  }
  const size_t front = points.size();
  for (int y = 10; y < 20; ++y) points.push_back({4 * (2 + 0.1f * y), 4 * 8.0f, 4});
  g = gaussians_at(points);
  for (Eigen::Vector3f& s : g.log_scale) s.setConstant(std::log(0.4f));
  for (float& o : g.opacity_logit) o = 5;
  for (size_t i = 0; i < g.size(); ++i) {
    const bool red = i < front && points[i].x() < 8;
    g.sh[i] = red ? Eigen::Vector3f(1.5f, -1.5f, -1.5f) : Eigen::Vector3f(-1.5f, -1.5f, 1.5f);
  }
  const Mask all = rectangle(0, kSize, 0, kSize);
  const std::vector<ViewMasks> views = {view_of(all, rectangle(0, 8, 0, kSize), rectangle(8, kSize, 0, kSize))};
  const std::vector<Camera> cameras = {pixel_camera()};
  const Inventory inventory = two_parts();
  using Occlusion = RunSpecification::Lifting::Occlusion;
  const Labels none = assign_rows({g, cameras, views, inventory, Occlusion::none});
  const Labels depth = assign_rows({g, cameras, views, inventory, Occlusion::depth});
  CHECK(depth.counts.hidden == 10);
  for (size_t i = front; i < g.size(); ++i) {
    CHECK(none.row[i] == 0);
    CHECK(depth.row[i] == 1);
    CHECK(depth.confidence[i] <= 0.20f);
  }
}

TEST_CASE("lift: the depth test does not let a view speak for a clear Gaussian through which it shows another part") {
  // A clear blue sheet in front of an opaque red one that covers the image's right half; the left half shows the blue
  // sheet alone. The masks say what is seen: blue (a) on the left, red (b) on the right.
  std::vector<Eigen::Vector3f> points;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) points.push_back({0.5f + x, 0.5f + y, 1});
  }
  const size_t clear = points.size();
  for (int y = 0; y < 32; ++y) {
    for (int x = 16; x < 32; ++x) points.push_back({1.01f * (0.25f + 0.5f * x), 1.01f * (0.25f + 0.5f * y), 1.01f});
  }
  Gaussians g = gaussians_at(points);
  for (Eigen::Vector3f& s : g.log_scale) s.setConstant(std::log(0.4f));
  for (size_t i = 0; i < g.size(); ++i) {
    g.opacity_logit[i] = i < clear ? -3 : 5;
    g.sh[i] = i < clear ? Eigen::Vector3f(-1.5f, -1.5f, 1.5f) : Eigen::Vector3f(1.5f, -1.5f, -1.5f);
  }
  const Mask all = rectangle(0, kSize, 0, kSize);
  const std::vector<ViewMasks> views = {view_of(all, rectangle(0, 8, 0, kSize), rectangle(8, kSize, 0, kSize))};
  const std::vector<Camera> cameras = {pixel_camera()};
  const Inventory inventory = two_parts();
  using Occlusion = RunSpecification::Lifting::Occlusion;
  const auto share_of_a = [&](Occlusion occlusion) {
    const Labels labels = assign_rows({g, cameras, views, inventory, occlusion});
    return double(std::count(labels.row.begin(), labels.row.begin() + clear, 0)) / double(clear);
  };
  // As the paper writes it, half of the clear sheet takes the row behind it; at the border a few may go either way.
  CHECK(share_of_a(Occlusion::none) == doctest::Approx(0.5).epsilon(0.1));
  CHECK(share_of_a(Occlusion::depth) > 0.97);
  const Labels labels = assign_rows({g, cameras, views, inventory, Occlusion::depth});
  CHECK(std::count(labels.row.begin() + clear, labels.row.end(), 1) == long(g.size() - clear));
}

TEST_CASE("lift: a part that is hidden in three of four views is labelled by the fourth") {
  // A sheet of part b at z = 1 hides all of a wider sheet of part a at z = 2 from the front; from behind it is a alone.
  std::vector<Eigen::Vector3f> points;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 15; ++x) points.push_back({0.3f + 0.5f * x, 0.3f + 0.5f * y, 1});
  }
  const size_t of_b = points.size();
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 30; ++x) points.push_back({0.3f + 0.5f * x, 0.3f + 0.5f * y, 2});
  }
  Gaussians g = gaussians_at(points);
  for (Eigen::Vector3f& s : g.log_scale) s.setConstant(std::log(0.4f));
  for (float& o : g.opacity_logit) o = 5;
  Camera behind = pixel_camera();
  behind.cx = kSize;
  behind.world_to_camera.diagonal() << -1, 1, -1, 1;
  behind.world_to_camera(2, 3) = 3;
  const Mask half = rectangle(0, 8, 0, kSize), all = rectangle(0, kSize, 0, kSize);
  const ViewMasks front = view_of(half, Mask(), half), back = view_of(all, all, Mask());
  const std::vector<Camera> cameras = {pixel_camera(), behind, behind, behind};
  const std::vector<ViewMasks> views = {front, back, back, back};
  const Inventory inventory = two_parts();
  const Labels labels = assign_rows({g, cameras, views, inventory, RunSpecification::Lifting::Occlusion::depth});
  // Where a rim of the hidden sheet shows beside the other, a few Gaussians may go either way.
  const auto share = [&](size_t from, size_t to, int row) {
    return double(std::count(labels.row.begin() + from, labels.row.begin() + to, row)) / double(to - from);
  };
  CHECK(share(0, of_b, 1) > 0.95);
  CHECK(share(of_b, points.size(), 0) > 0.95);
}

TEST_CASE("lift: masks of nothing, of everything, and of another object leave every Gaussian with one row") {
  const std::vector<Eigen::Vector3f> points = {{2, 8, 1}, {3, 8, 1}, {12, 8, 1}, {13, 8, 1}};
  const Mask all = rectangle(0, kSize, 0, kSize), right = rectangle(8, kSize, 0, kSize);
  // A mask without a pixel counts as none.
  CHECK(lift_once(points, view_of(all, rectangle(0, 0, 0, 0), right)).row ==
        lift_once(points, view_of(all, Mask(), right)).row);
  // A mask of everything takes what no other mask supports better.
  const Labels everything = lift_once(points, view_of(all, all, right));
  CHECK(std::count(everything.row.begin(), everything.row.end(), 2) == 0);
  CHECK(everything.row[0] == 0);
  for (const float c : everything.confidence) CHECK((c >= 0 && c <= 1));
  // A second object with the first one's mask: the order of queries decides.
  Inventory inventory = two_parts();
  inventory.objects.push_back(inventory.objects[0]);
  inventory.objects[1].id = "other";
  for (int r = 0; r < 3; ++r) {
    inventory.rows.push_back(inventory.rows[r]);
    inventory.rows.back().object = "other";
  }
  ViewMasks view;
  view.objects = {all, all};
  view.rows = {all, Mask(), Mask(), all, Mask(), Mask()};
  const Gaussians g = gaussians_at(points);
  const std::vector<Camera> cameras = {pixel_camera()};
  const std::vector<ViewMasks> views = {view};
  const Labels twice = assign_rows({g, cameras, views, inventory});
  CHECK(twice.object == std::vector<int32_t>{0, 0, 0, 0});
  CHECK(twice.row == std::vector<int32_t>{0, 0, 0, 0});
}

TEST_CASE("lift: nearest neighbours come by distance, then by index") {
  const std::vector<Eigen::Vector3f> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 3}, {0, 0, 0}};
  const NeighborSearch<3> search(points, {0, 1, 2, 3, 4, 5});
  const std::vector<Neighbor> around = search.around(3, 4);
  REQUIRE(around.size() == 4);
  CHECK(around[0].index == 5);
  CHECK(around[1].index == 0);
  CHECK(around[2].index == 1);
  CHECK(around[3].index == 2);
  CHECK(search.nearest({0, 0, 0}, 1)[0].index == 3);
  CHECK(NeighborSearch<3>(points, {}).nearest({0, 0, 0}, 3).empty());
}

TEST_CASE("lift: the labels do not depend on the number of threads") {
  std::vector<Eigen::Vector3f> points;
  uint32_t seed = 1;
  const auto random = [&] { return static_cast<float>((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 24); };
  for (int i = 0; i < 3000; ++i) points.push_back({18 * random() - 1, 18 * random() - 1, 1});
  const ViewMasks view = view_of(rectangle(0, 14, 0, 14), rectangle(0, 9, 0, 14, 0.8), rectangle(5, 13, 2, 12, 0.85));
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const Labels one = lift_once(points, view);
  omp_set_num_threads(4);
  const Labels four = lift_once(points, view);
  omp_set_num_threads(before);
  CHECK(one.row == four.row);
  CHECK(one.confidence == four.confidence);
}
