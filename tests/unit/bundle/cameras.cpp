#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <tuple>

#include "bundle/view_rig.h"
#include "records/run_specification.h"
#include "scene/placement.h"

using namespace physmas;
using namespace physmas::bundle;
using Eigen::Vector3d;

namespace {

const std::vector<Vector3d> kCorners = {{-1, -2, 0}, {1, -2, 0}, {-1, 2, 0}, {1, 2, 0},
                                        {-1, -2, 3}, {1, -2, 3}, {-1, 2, 3}, {1, 2, 3}};

}  // namespace

TEST_CASE("look_at puts the target into the middle, up towards the top and right to the right") {
  const Camera camera = look_at({0, -5, 1}, {0, 0, 1}, {0, 0, 1}, 0.6, 200, 100);
  CHECK(camera.center().isApprox(Vector3d(0, -5, 1), 1e-12));
  CHECK(camera.to_camera({0, 0, 1}).isApprox(Vector3d(0, 0, 5), 1e-12));
  const Eigen::Vector2d middle = camera.project(camera.to_camera({0, 0, 1}));
  CHECK(middle.x() == doctest::Approx(100));
  CHECK(middle.y() == doctest::Approx(50));
  CHECK(camera.project(camera.to_camera({0, 0, 1.5})).y() < 50);
  CHECK(camera.project(camera.to_camera({0.5, 0, 1})).x() > 100);
  // Half the angle of view reaches the upper edge.
  CHECK(camera.project(camera.to_camera({0, 0, 1 + 5 * std::tan(0.3)})).y() == doctest::Approx(0).epsilon(1e-9));
  CHECK(camera.rotation().determinant() == doctest::Approx(1));
}

TEST_CASE("scene axes are rotations, and the front camera looks where the table says") {
  for (const char* up : {"x", "y", "z", "-x", "-y", "-z"}) {
    const Eigen::Matrix3d axes = scene_axes(up);
    CHECK((axes * axes.transpose()).isIdentity(1e-12));
    CHECK(axes.determinant() == doctest::Approx(1));
  }
  CHECK(scene_axes("z").isIdentity());
  CHECK(scene_axes("-y").col(1).isApprox(Vector3d::UnitZ()));
  CHECK(scene_axes("y").col(1).isApprox(Vector3d(-Vector3d::UnitZ())));
  CHECK_THROWS(scene_axes("w"));
}

TEST_CASE("the front: an axis or degrees turn the scene's axes about up") {
  // With z up the usual front faces -y, and the right view stands on +x.
  CHECK(front_degrees("-y", "z") == 0);
  CHECK(*front_degrees("x", "z") == doctest::Approx(90));
  CHECK(std::abs(*front_degrees("y", "z")) == doctest::Approx(180));
  CHECK(*front_degrees("-x", "z") == doctest::Approx(-90));
  CHECK(front_degrees("33.5", "z") == 33.5);
  for (const char* no : {"400", "north", "", "-", "nan", "12deg"}) CHECK_FALSE(front_degrees(no, "z").has_value());
  CHECK_THROWS(front_degrees("z", "z"));
  CHECK_THROWS(front_degrees("-y", "y"));
  for (const char* up : {"x", "-x", "y", "-y", "z", "-z"}) {
    for (const char* front : {"x", "-x", "y", "-y", "z", "-z"}) {
      if (front[std::strlen(front) - 1] == up[std::strlen(up) - 1]) continue;
      const Eigen::Matrix3d axes = scene_axes(up, *front_degrees(front, up));
      CAPTURE(up);
      CAPTURE(front);
      CHECK((axes * axes.transpose()).isIdentity(1e-12));
      CHECK(axes.determinant() == doctest::Approx(1));
      // The front camera looks against the way that the front faces, and is level.
      CHECK(axes.col(1) == Vector3d(-axis_vector(front)));
      CHECK(axes.col(2) == axis_vector(up));
    }
  }
}

TEST_CASE("views and the output camera turn with the front") {
  const Framing usual = {"z", 40, 0.1, 200, 200}, turned = {"z", 40, 0.1, 200, 200, 90};
  const std::vector<Camera> before = view_cameras(kCorners, 10, usual), after = view_cameras(kCorners, 10, turned);
  // What was the right view is the front; the others follow.
  for (size_t i = 0; i < 4; ++i) CHECK(after[i].world_to_camera.isApprox(before[(i + 1) % 4].world_to_camera, 1e-9));
  const Camera output = frame_points(kCorners, {25, 15}, turned);
  CHECK(output.world_to_camera.isApprox(frame_points(kCorners, {115, 15}, usual).world_to_camera, 1e-9));
  CHECK(azimuth_of(output, middle_of(kCorners), "z") == doctest::Approx(115).epsilon(0.02));
}

TEST_CASE("a framed camera sees every point, and could not be nearer") {
  // Wide, so that the upper or lower edge decides, and narrow, so that one at the side does.
  for (const auto& [up, width, height] :
       {std::tuple("z", 300, 200), {"-y", 300, 200}, {"z", 100, 200}, {"-y", 100, 200}}) {
    const Framing framing = {up, 40, 0.1, width, height};
    const Camera camera = frame_points(kCorners, {25, 15}, framing);
    double worst = 0;
    for (const Vector3d& p : kCorners) {
      const Vector3d q = camera.to_camera(p);
      REQUIRE(q.z() > 0);
      const Eigen::Vector2d pixel = camera.project(q);
      worst = std::max({worst, std::abs(pixel.x() / width - 0.5) * 2, std::abs(pixel.y() / height - 0.5) * 2});
    }
    CHECK(worst == doctest::Approx(0.9).epsilon(1e-9));
  }
}

TEST_CASE("the four views look from front, right, back and left at one distance") {
  const std::vector<Camera> cameras = view_cameras(kCorners, 0, {"z", 40, 0.1, 100, 100});
  REQUIRE(cameras.size() == 4);
  CHECK(cameras[0].center().y() < -2);
  CHECK(cameras[1].center().x() > 1);
  CHECK(cameras[2].center().y() > 2);
  CHECK(cameras[3].center().x() < -1);
}

TEST_CASE("stray Gaussians do not move the views") {
  Gaussians gaussians;
  gaussians.resize(1001, 0);
  for (int i = 0; i < 1000; ++i)
    gaussians.position[i] = {static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100)};
  gaussians.position[1000] = {500, 0, 0};
  CHECK(means_of(gaussians).size() == 1001);
  CHECK(robust_means_of(gaussians).size() == 1000);
}

TEST_CASE("the solver's map puts the bounding box where the placement says") {
  Gaussians gaussians;
  gaussians.resize(2, 0);
  gaussians.position = {{0, 0, 0}, {1, 4, 2}};
  RunSpecification run;
  run.placement.center = {1, 1, 0.8};
  const SolverMap map = solver_map(gaussians, run);
  CHECK(map.s == doctest::Approx(0.25));
  CHECK(map.to_solver({0.5, 2, 1}).isApprox(Vector3d(1, 1, 0.8), 1e-12));
  CHECK(heights_of(gaussians, run).lowest == doctest::Approx(0.55));
  run.placement.up = "-y";
  CHECK(heights_of(gaussians, run).lowest == doctest::Approx(-1.5));
  CHECK(wall_heights(run).lowest == doctest::Approx(-2 + 3 * run.grid.dx()));
  const RunSpecification::Collider floor = floor_at(-1.6, run);
  CHECK(floor.normal.isApprox(Vector3d(0, -1, 0)));
  CHECK(floor.point.isApprox(Vector3d(1, 1.6, 1), 1e-12));
}
