// The floor of a picture and the shadows on it.
#include "splat/floor_shadow.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>

#include "splat/quantize.h"
#include "unit/splat/scenes.h"

using namespace physmas;
using namespace physmas::splat;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

const Vector3f kWhite = Vector3f::Ones();

// A disc of Gaussians across z, radius 0.3, at a height above z = 0, and four posts that keep the scene's size.
Gaussians disc(float height) {
  std::vector<Vector3f> places;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      if (i * i + j * j <= 36) places.emplace_back(0.05f * i, 0.05f * j, height);
    }
  }
  Gaussians g = splat_test::one_gaussian(0.03f, 0.9f, 0.2f);
  g.position = places;
  g.rotation.resize(places.size(), g.rotation[0]);
  g.log_scale.resize(places.size(), g.log_scale[0]);
  g.opacity_logit.resize(places.size(), g.opacity_logit[0]);
  g.sh.resize(places.size(), g.sh[0]);
  return g;
}

const FloorPlane kFloor = {{0, 0, 0}, {0, 0, 1}};

// From straight above, so that a pixel shows the point of the floor below it: 200 pixels are 4 units.
Camera from_above() {
  return look_at({0, 0, 40}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(2.0 / 40), 200, 200);
}

// The floor's grey levels along a line through the middle, with nothing in front of it. The disc is moved up from where
// it lies at rest, so that the floor's own measures stay.
std::vector<int> profile(float height) {
  const Gaussians rest = disc(0.02f);
  FloorShadow floor(rest, kFloor, kWhite);
  const Gaussians moved = disc(height);
  const std::vector<RowMatrix3f> F(moved.size(), RowMatrix3f::Identity());
  floor.update({moved.position.data(), F.data()});
  RenderedImage empty;
  empty.width = empty.height = 200;
  empty.rgb.assign(3 * 200 * 200, 1);
  empty.alpha.assign(200 * 200, 0);
  const Image picture = floor.picture(empty, from_above());
  std::vector<int> levels;
  for (int x = 0; x < 200; ++x) levels.push_back(picture.at(x, 100)[1]);
  return levels;
}

int darkest(const std::vector<int>& levels) {
  return *std::min_element(levels.begin(), levels.end());
}

// Pixels in which the shadow goes from a fifth to four fifths of its depth, on the left side.
int softness(const std::vector<int>& levels) {
  const int deep = levels[100], bright = *std::max_element(levels.begin() + 30, levels.begin() + 100);
  int pixels = 0;
  for (int x = 30; x < 100; ++x)
    pixels += levels[x] > deep + 0.2 * (bright - deep) && levels[x] < deep + 0.8 * (bright - deep);
  return pixels;
}

}  // namespace

TEST_CASE("floor: shadows of what is higher are softer and fainter, and fade out in the end") {
  const std::vector<int> contact = profile(0.02f), low = profile(0.2f), high = profile(0.6f);
  CHECK(contact[100] < low[100]);
  CHECK(low[100] < high[100]);
  CHECK(softness(contact) < softness(low));
  CHECK(softness(low) < softness(high));
  CHECK(contact[100] < 190);
  CHECK(high[100] < high[100 - 60]);
}

TEST_CASE("floor: nothing jumps when things rise or slide a little") {
  // From one layer over the next to the one after.
  std::vector<int> before = profile(0.1f);
  for (float height = 0.102f; height < 0.25f; height *= 1.02f) {
    const std::vector<int> after = profile(height);
    for (int x = 0; x < 200; ++x) CHECK(std::abs(after[x] - before[x]) <= 3);
    before = after;
  }
}

TEST_CASE("floor: it fades into the background, and is not seen from below or where Gaussians cover it") {
  const std::vector<int> levels = profile(0.02f);
  CHECK(levels[0] >= 253);
  CHECK(levels[50] < 250);
  const Gaussians g = disc(0.02f);
  FloorShadow floor(g, kFloor, kWhite);
  floor.update({});
  RenderedImage image;
  image.width = image.height = 200;
  image.rgb.assign(3 * 200 * 200, 0.5f);
  image.alpha.assign(200 * 200, 1);
  CHECK(floor.picture(image, from_above()).pixels == quantize(image).pixels);
  image.alpha.assign(200 * 200, 0);
  const Camera below = look_at({0, -20, -40}, {0, 0, 0}, {0, 1, 0}, 0.1, 200, 200);
  CHECK(floor.picture(image, below).pixels == quantize(image).pixels);
  CHECK(floor.picture(image, from_above()).pixels != quantize(image).pixels);
}

TEST_CASE("floor: the rendered image, which is measured, is left alone; threads change nothing") {
  const Gaussians g = disc(0.3f);
  Renderer renderer(g);
  RenderOptions options;
  options.background = kWhite;
  const Camera camera = look_at({0, -3, 2}, {0, 0, 0}, {0, 0, 1}, 0.6, 120, 90);
  const RenderedImage before = renderer.render(camera, {}, options);
  Image first;
  for (const int threads : {1, 3}) {
    omp_set_num_threads(threads);
    FloorShadow floor(g, kFloor, kWhite);
    const RenderedImage& image = renderer.render(camera, {}, options);
    floor.update({});
    const Image picture = floor.picture(image, camera);
    CHECK(image.rgb == before.rgb);
    CHECK(image.alpha == before.alpha);
    if (first.pixels.empty()) first = picture;
    CHECK(first.pixels == picture.pixels);
    CHECK(picture.pixels != quantize(image).pixels);
  }
  omp_set_num_threads(omp_get_num_procs());
}

TEST_CASE("floor: Gaussians that are not finite, or far away, throw no shadow and do no harm") {
  Gaussians g = disc(0.02f);
  std::vector<Vector3f> places = g.position;
  std::vector<RowMatrix3f> F(g.size(), RowMatrix3f::Identity());
  for (size_t i = 0; i < places.size(); ++i) {
    if (i % 3 == 0) places[i].x() = NAN;
    if (i % 3 == 1) places[i].x() = 1e30f;
    if (i % 3 == 2) F[i] *= 1e30f;
  }
  FloorShadow floor(g, kFloor, kWhite);
  floor.update({places.data(), F.data()});
  RenderedImage empty;
  empty.width = empty.height = 200;
  empty.rgb.assign(3 * 200 * 200, 1);
  empty.alpha.assign(200 * 200, 0);
  CHECK(darkest(profile(0.02f)) < 190);
  CHECK(floor.picture(empty, from_above()).at(100, 100)[0] > 60);
}

TEST_CASE("floor: the plane that faces up, a box below, or the wall") {
  RunSpecification run;
  run.grid.n = 50;
  SolverMap map;
  map.s = 0.5;
  map.d = {1, 1, 1};
  const Gaussians g = disc(0.5f);
  FloorPlane plane = floor_plane(run, map, g);
  CHECK(map.to_solver(plane.point).z() == doctest::Approx(3 * 0.04));
  CHECK(plane.normal == Vector3d::UnitZ());
  RunSpecification::Collider box;
  box.type = RunSpecification::Collider::Type::box;
  box.min = {0, 0, 0}, box.max = {2, 2, 0.3};
  run.colliders = {box};
  CHECK(map.to_solver(floor_plane(run, map, g).point).z() == doctest::Approx(0.3));
  RunSpecification::Collider wall, floor;
  wall.normal = {1, 0, 0};
  floor.point = {0, 0, 0.4};
  run.colliders = {box, wall, floor};
  CHECK(map.to_solver(floor_plane(run, map, g).point).z() == doctest::Approx(0.4));
  run.placement.up = "-z";
  run.colliders.clear();
  plane = floor_plane(run, map, g);
  CHECK(plane.normal == Vector3d(-Vector3d::UnitZ()));
  CHECK(map.to_solver(plane.point).z() == doctest::Approx(2 - 3 * 0.04));
}
