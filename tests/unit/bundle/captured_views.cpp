#include "bundle/captured_views.h"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "bundle/choose_views.h"
#include "bundle/dataparser_transform.h"
#include "records/json.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::bundle;
using Eigen::Vector3d;

namespace {

// A camera at (3, -4, 2) that looks at the origin with z up; 200 x 100 pixels, fx = 150, fy = 140.
Camera known_camera() {
  Camera camera = look_at({3, -4, 2}, {0, 0, 0}, {0, 0, 1}, 1, 200, 100);
  camera.fx = 150, camera.fy = 140;
  return camera;
}

// Computed by hand from the pose: forward = (-3, 4, -2)/sqrt(29), right = (4, 3, 0)/5, down = forward x right.
const Vector3d kPoint(0.5, 0.25, -0.3);
Eigen::Vector2d known_pixel() {
  const Vector3d q = kPoint - Vector3d(3, -4, 2);
  const Vector3d forward = Vector3d(-3, 4, -2) / std::sqrt(29.0), right = Vector3d(4, 3, 0) / 5.0;
  const Vector3d down = forward.cross(right);
  return {150 * q.dot(right) / q.dot(forward) + 100, 140 * q.dot(down) / q.dot(forward) + 50};
}

void check_projects(const CapturedView& view, const std::string& image) {
  CHECK(view.image == image);
  CHECK(view.camera.width == 200);
  CHECK(view.camera.height == 100);
  const Eigen::Vector2d pixel = view.camera.project(view.camera.to_camera(kPoint)), expected = known_pixel();
  CHECK(pixel.x() == doctest::Approx(expected.x()).epsilon(1e-9));
  CHECK(pixel.y() == doctest::Approx(expected.y()).epsilon(1e-9));
}

// Camera to world with OpenGL axes, as transforms.json has it; `after` is applied to the pose.
Json opengl_pose(const Camera& camera, const Eigen::Matrix4d& after = Eigen::Matrix4d::Identity()) {
  Eigen::Matrix4d pose = camera.world_to_camera.inverse();
  pose.col(1) *= -1;
  pose.col(2) *= -1;
  pose = after * pose;
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({pose(r, 0), pose(r, 1), pose(r, 2), pose(r, 3)});
  return rows;
}

std::vector<CapturedView> views_of(const Json& document) {
  return captured_views_from(document, "t.json", [](const std::string&) { return std::make_pair(200, 100); });
}

std::string error_of(const Json& document) {
  return message_of([&] { views_of(document); });
}

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

struct Pose {
  double q[4], t[3];
};
Pose colmap_pose() {
  const Camera camera = known_camera();
  const Eigen::Quaterniond q(camera.rotation());
  const Vector3d t = camera.translation();
  return {{q.w(), q.x(), q.y(), q.z()}, {t.x(), t.y(), t.z()}};
}

ColmapFiles colmap_text(const std::string& camera) {
  const Pose p = colmap_pose();
  ColmapFiles files = {"cameras.txt", "images.txt", "# Camera list\n" + camera + "\n", "# Image list\n#\n", false};
  files.images += fmt::format("1 {} {} {} {} {} {} {} 7 dir/a picture.jpg\n1.5 2.5 -1 3 4 12\n", p.q[0], p.q[1], p.q[2],
                              p.q[3], p.t[0], p.t[1], p.t[2]);
  files.images +=
      fmt::format("2 {} {} {} {} {} {} {} 7 b.jpg\n\n", p.q[0], p.q[1], p.q[2], p.q[3], p.t[0], p.t[1], p.t[2]);
  return files;
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

ColmapFiles colmap_binary() {
  const Pose p = colmap_pose();
  ColmapFiles files = {"cameras.bin", "images.bin", "", "", true};
  put<uint64_t>(files.cameras, 1);
  put<uint32_t>(files.cameras, 7), put<int32_t>(files.cameras, 1);
  put<uint64_t>(files.cameras, 200), put<uint64_t>(files.cameras, 100);
  for (double v : {150.0, 140.0, 100.0, 50.0}) put(files.cameras, v);
  put<uint64_t>(files.images, 1);
  put<uint32_t>(files.images, 1);
  for (double v : p.q) put(files.images, v);
  for (double v : p.t) put(files.images, v);
  put<uint32_t>(files.images, 7);
  files.images += std::string("a.jpg") + '\0';
  put<uint64_t>(files.images, 2);
  files.images += std::string(48, 'p');
  return files;
}

}  // namespace

TEST_CASE("cameras: transforms.json with focal lengths, and with angles of view") {
  const Json pose = opengl_pose(known_camera());
  check_projects(views_of({{"w", 200},
                           {"h", 100.0},
                           {"fl_x", 150},
                           {"fl_y", 140},
                           {"k1", 0},
                           {"camera_model", "OPENCV"},
                           {"frames", {{{"file_path", "images/a.png"}, {"transform_matrix", pose}}}}})
                     .at(0),
                 "images/a.png");
  // Blender's files know neither size nor focal length; the size is the image's.
  check_projects(views_of({{"camera_angle_x", 2 * std::atan(100.0 / 150)},
                           {"camera_angle_y", 2 * std::atan(50.0 / 140)},
                           {"frames", {{{"file_path", "./train/r_0"}, {"transform_matrix", pose}}}}})
                     .at(0),
                 "./train/r_0");
  // A frame's own lens wins.
  check_projects(views_of({{"w", 9},
                           {"h", 9},
                           {"fl_x", 1},
                           {"cx", 3},
                           {"cy", 3},
                           {"frames",
                            {{{"file_path", "a"},
                              {"transform_matrix", pose},
                              {"w", 200},
                              {"h", 100},
                              {"fl_x", 150},
                              {"fl_y", 140},
                              {"cx", 100},
                              {"cy", 50}}}}})
                     .at(0),
                 "a");
}

TEST_CASE("cameras: transforms.json undoes its applied transform") {
  Eigen::Matrix4d applied = Eigen::Matrix4d::Identity();
  applied.topRows<3>() << 0, 1, 0, 0.5, 1, 0, 0, -1, 0, 0, -1, 2;
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({applied(r, 0), applied(r, 1), applied(r, 2), applied(r, 3)});
  Json document = {{"w", 200}, {"h", 100}, {"fl_x", 150}, {"fl_y", 140}, {"applied_transform", rows}};
  document["frames"] = {{{"file_path", "a"}, {"transform_matrix", opengl_pose(known_camera(), applied)}}};
  check_projects(views_of(document).at(0), "a");
}

TEST_CASE("cameras: nerfstudio's dataparser transform moves cameras into the frame of the Gaussians") {
  // The point and the camera that the checks know are in nerfstudio's frame: scale (R x + t) of the capture.
  const double scale = 0.37;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.8, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vector3d t(0.3, -4, 1.5);
  Camera captured = known_camera();
  const Vector3d center = R.transpose() * (captured.center() / scale - t);
  captured.world_to_camera.topLeftCorner<3, 3>() = captured.rotation() * R;
  captured.world_to_camera.topRightCorner<3, 1>() = -captured.rotation() * center;
  Json transform = {{"scale", scale}, {"transform", Json::array()}};
  for (int r = 0; r < 3; ++r) transform["transform"].push_back({R(r, 0), R(r, 1), R(r, 2), t(r)});
  // ns-process-data turns the capture before it writes transforms.json; the dataparser takes that back.
  Eigen::Matrix4d applied = Eigen::Matrix4d::Identity();
  applied.topRows<3>() << 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0;
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({applied(r, 0), applied(r, 1), applied(r, 2), applied(r, 3)});
  Json document = {{"w", 200}, {"h", 100}, {"fl_x", 150}, {"fl_y", 140}, {"applied_transform", rows}};
  document["frames"] = {{{"file_path", "a"}, {"transform_matrix", opengl_pose(captured, applied)}}};
  std::vector<CapturedView> views = views_of(document);
  dataparser_transform_from(transform, "d.json").apply(views.at(0).camera);
  check_projects(views.at(0), "a");

  // applied_scale: the file's positions are larger than the capture's.
  document["applied_scale"] = 2;
  for (int r = 0; r < 3; ++r) {
    Json& position = document["frames"][0]["transform_matrix"][r][3];
    position = 2 * position.get<double>();
  }
  views = views_of(document);
  dataparser_transform_from(transform, "d.json").apply(views.at(0).camera);
  check_projects(views.at(0), "a");

  const auto refused = [](const Json& json) { return message_of([&] { dataparser_transform_from(json, "d.json"); }); };
  Json bad = transform;
  bad["scale"] = 0;
  CHECK(refused(bad).find("d.json: /scale") != std::string::npos);
  bad = transform;
  bad["transform"][0][0] = 3;
  CHECK(refused(bad).find("/transform") != std::string::npos);
  bad["transform"] = "none";
  CHECK(refused(bad).find("/transform") != std::string::npos);
  CHECK(refused(Json::array()).find("d.json") != std::string::npos);
}

TEST_CASE("cameras: the dataparser transform is found beside the Gaussians, then beside the cameras") {
  const TemporaryFolder folder;
  for (const char* name : {"export", "data", "data/sparse"}) std::filesystem::create_directory(folder / name);
  const std::string gaussians = folder / "export/splat.ply", cameras = folder / "data/transforms.json";
  CHECK(find_dataparser_transform(gaussians, cameras).empty());
  std::ofstream(folder / "data/dataparser_transforms.json") << "{}";
  CHECK(find_dataparser_transform(gaussians, cameras) == folder / "data/dataparser_transforms.json");
  CHECK(find_dataparser_transform(gaussians, folder / "data") == folder / "data/dataparser_transforms.json");
  CHECK(find_dataparser_transform(gaussians, folder / "data/sparse").empty());
  std::ofstream(folder / "export/dataparser_transforms.json") << "{}";
  CHECK(find_dataparser_transform(gaussians, cameras) == folder / "export/dataparser_transforms.json");
}

TEST_CASE("cameras: transforms.json that is no pinhole, or broken, is refused") {
  const Json good = {{"w", 200},
                     {"h", 100},
                     {"fl_x", 150},
                     {"frames", {{{"file_path", "a"}, {"transform_matrix", opengl_pose(known_camera())}}}}};
  const auto with = [&](const char* pointer, const Json& value) {
    Json changed = good;
    changed[Json::json_pointer(pointer)] = value;
    return error_of(changed);
  };
  CHECK(error_of(good) == "no error");
  CHECK(contains(with("/k1", -9), "folds"));
  CHECK(contains(with("/frames/0/k4", -1e-3), "/frames/0/k4"));
  CHECK(contains(with("/frames/0/p2", "much"), "/frames/0/p2"));
  CHECK(contains(with("/camera_model", "OPENCV_FISHEYE"), "undistort"));
  CHECK(contains(with("/fl_x", 0), "/fl_x"));
  CHECK(contains(with("/w", 1.5), "/w"));
  CHECK(contains(with("/w", "200"), "/w"));
  CHECK(contains(with("/frames", Json::array()), "/frames"));
  CHECK(contains(with("/frames/0", 3), "/frames/0"));
  CHECK(contains(with("/frames/0/transform_matrix/0/0", 5), "rotation"));
  CHECK(contains(with("/frames/0/transform_matrix", {1, 2}), "3 rows"));
  CHECK(contains(error_of(Json::object()), "another kind"));
}

TEST_CASE("cameras: 3DGS cameras.json") {
  const Camera camera = known_camera();
  const Eigen::Matrix3d R = camera.rotation().transpose();
  const Vector3d p = camera.center();
  Json rotation = Json::array();
  for (int r = 0; r < 3; ++r) rotation.push_back({R(r, 0), R(r, 1), R(r, 2)});
  Json entry = {{"id", 0},
                {"img_name", "00001"},
                {"width", 200},
                {"height", 100},
                {"position", {p.x(), p.y(), p.z()}},
                {"rotation", rotation},
                {"fy", 140},
                {"fx", 150}};
  check_projects(views_of(Json::array({entry})).at(0), "00001");
  entry["position"] = {1, 2};
  CHECK(contains(error_of(Json::array({entry})), "/0/position"));
}

TEST_CASE("cameras: COLMAP text") {
  for (const char* line : {"7 PINHOLE 200 100 150 140 100 50", "7 OPENCV 200 100 150 140 100 50 0 0 0 0"}) {
    const std::vector<CapturedView> views = views_from_colmap(colmap_text(line));
    REQUIRE(views.size() == 2);
    check_projects(views[0], "dir/a picture.jpg");
    check_projects(views[1], "b.jpg");
  }
  CHECK(views_from_colmap(colmap_text("7 SIMPLE_PINHOLE 200 100 150 100 50"))[0].camera.fy == 150);
  const auto refused = [](const char* line) { return message_of([&] { views_from_colmap(colmap_text(line)); }); };
  CHECK(contains(refused("7 SIMPLE_RADIAL 200 100 150 100 50 -9"), "image_undistorter"));
  CHECK(contains(refused("7 FULL_OPENCV 200 100 150 140 100 50 0.1 0 0 0 0 0.2 0 0"), "FULL_OPENCV with k4"));
  CHECK(contains(refused("7 OPENCV_FISHEYE 200 100 150 140 100 50 0 0 0 0"), "image_undistorter"));
  CHECK(contains(refused("7 PINHOLE 200 100 150 140 100"), "line 2"));
  CHECK(contains(refused("7 PINHOLE 200 100 150 140 100 50 1"), "4 for PINHOLE"));
  CHECK(contains(refused("7 PINHOLE 0 100 150 140 100 50"), "pixels"));
  CHECK(contains(refused("7 WIDE 200 100 150 140 100 50"), "WIDE"));
  CHECK(contains(refused("8 PINHOLE 200 100 150 140 100 50"), "camera 7"));
  CHECK(contains(refused("7 PINHOLE 200 100 nan 140 100 50"), "line 2"));
}

TEST_CASE("cameras: distortion is read in the order of each format") {
  const auto colmap = [](const char* line) { return views_from_colmap(colmap_text(line)).at(0).distortion; };
  const auto check = [](const Distortion& d, double k1, double k2, double k3, double p1, double p2) {
    CHECK(d.k1 == k1);
    CHECK(d.k2 == k2);
    CHECK(d.k3 == k3);
    CHECK(d.p1 == p1);
    CHECK(d.p2 == p2);
  };
  check(colmap("7 PINHOLE 200 100 150 140 100 50"), 0, 0, 0, 0, 0);
  check(colmap("7 SIMPLE_RADIAL 200 100 150 100 50 0.1"), 0.1, 0, 0, 0, 0);
  check(colmap("7 RADIAL 200 100 150 100 50 0.1 0.2"), 0.1, 0.2, 0, 0, 0);
  check(colmap("7 OPENCV 200 100 150 140 100 50 0.1 0.2 0.01 0.02"), 0.1, 0.2, 0, 0.01, 0.02);
  check(colmap("7 FULL_OPENCV 200 100 150 140 100 50 0.1 0.2 0.01 0.02 0.3 0 0 0"), 0.1, 0.2, 0.3, 0.01, 0.02);
  Json document = {{"w", 200}, {"h", 100}, {"fl_x", 150}, {"k1", 0.1}, {"k2", 0.2}, {"k3", 0.3}, {"p1", 0.01}};
  document["frames"] = {{{"file_path", "a"}, {"transform_matrix", opengl_pose(known_camera())}, {"p2", 0.02}}};
  check(views_of(document).at(0).distortion, 0.1, 0.2, 0.3, 0.01, 0.02);
}

TEST_CASE("cameras: an undistorted picture shows at each pixel what the lens put elsewhere") {
  // Grey levels that grow by one per pixel to the right, and red ones downwards: bilinear sampling is exact in them.
  Camera camera;
  camera.width = 200, camera.height = 100, camera.fx = 150, camera.fy = 140, camera.cx = 101, camera.cy = 49;
  Image image(200, 100, 3);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 200; ++x)
      image.at(x, y)[0] = static_cast<uint8_t>(y), image.at(x, y)[1] = static_cast<uint8_t>(x);
  }
  CHECK(undistorted(image, camera, {}).pixels == image.pixels);
  const Distortion lens = {-0.2, 0.05, 0, 0.01, -0.02};
  const Image straight = undistorted(image, camera, lens);
  // By hand for the centre of pixel (175, 24): x = 74.5/150, y = -24.5/140.
  const double x = 74.5 / 150, y = -24.5 / 140, r2 = x * x + y * y;
  const double radial = 1 - 0.2 * r2 + 0.05 * r2 * r2;
  const double u = 150 * (x * radial + 0.02 * x * y - 0.02 * (r2 + 2 * x * x)) + 101 - 0.5,
               v = 140 * (y * radial + 0.01 * (r2 + 2 * y * y) - 0.04 * x * y) + 49 - 0.5;
  CHECK(straight.at(175, 24)[1] == std::lround(u));
  CHECK(straight.at(175, 24)[0] == std::lround(v));
  CHECK(std::abs(u - 175) > 2);  // the lens does something there
  // The other way round the lens saw less than the pinhole: the border is repeated.
  const Image wide = undistorted(image, camera, {0.5, 0, 0, 0, 0});
  CHECK(wide.at(0, 0)[1] == 0);
  CHECK(wide.at(199, 99)[0] == 99);
}

TEST_CASE("cameras: COLMAP binary, whole and cut at every byte") {
  const ColmapFiles whole = colmap_binary();
  check_projects(views_from_colmap(whole).at(0), "a.jpg");
  for (size_t n = 0; n < whole.cameras.size(); ++n) {
    ColmapFiles cut = whole;
    cut.cameras.resize(n);
    CHECK(contains(message_of([&] { views_from_colmap(cut); }), "cameras.bin"));
  }
  for (size_t n = 0; n < whole.images.size(); ++n) {
    ColmapFiles cut = whole;
    cut.images.resize(n);
    CHECK(contains(message_of([&] { views_from_colmap(cut); }), "images.bin"));
  }
  ColmapFiles many = whole;
  std::memset(&many.images[0], 0xff, 8);
  CHECK(contains(message_of([&] { views_from_colmap(many); }), "18446744073709551615 records"));
}

TEST_CASE("cameras: a COLMAP model is found by its folder or one of its files") {
  const TemporaryFolder folder;
  const ColmapFiles files = colmap_binary();
  std::ofstream(folder / "cameras.bin", std::ios::binary) << files.cameras;
  CHECK(contains(message_of([&] { load_captured_views(folder.path(), {}); }), "no COLMAP model"));
  std::ofstream(folder / "images.bin", std::ios::binary) << files.images;
  check_projects(load_captured_views(folder.path(), {}).at(0), "a.jpg");
  check_projects(load_captured_views(folder / "cameras.bin", {}).at(0), "a.jpg");
}

TEST_CASE("cameras: four views of many are those nearest to front, right, back and left") {
  std::vector<CapturedView> views;
  for (int degrees = 0; degrees < 360; degrees += 20) {
    const double a = degrees * std::acos(-1) / 180;
    views.push_back(
        {std::to_string(degrees), look_at({5 * std::sin(a), -5 * std::cos(a), 1}, {0, 0, 0}, {0, 0, 1}, 1, 64, 64)});
  }
  // Right in front, but looking away.
  views.insert(views.begin(), {"away", look_at({0, -5, 0}, {0, -9, 0}, {0, 0, 1}, 1, 64, 64)});
  const std::vector<Vector3d> points = {{-1, -1, -1}, {1, 1, 1}};
  const auto chosen = choose_views(views, points, "z", "c.json");
  CHECK(views[chosen[0].index].image == "0");
  CHECK(views[chosen[1].index].image == "80");  // 80 and 100 are as far off; the first wins
  CHECK(views[chosen[2].index].image == "180");
  CHECK(views[chosen[3].index].image == "260");
  CHECK(chosen[0].angle == doctest::Approx(std::atan(0.2) * 180 / std::acos(-1)));
  // Another front: the sides turn with it.
  const auto turned = choose_views(views, points, "z", "c.json", 160);
  CHECK(views[turned[0].index].image == "160");
  CHECK(views[turned[2].index].image == "340");
  CHECK(views[turned[3].index].image == "60");
  // A view that must be the front is it, although another would fit as well.
  CHECK(views[choose_views(views, points, "z", "c.json", 0, 3)[0].index].image == "40");
  CHECK(contains(message_of([&] { choose_views(views, points, "z", "c.json", 0, 0); }), "does not see"));
  views.resize(4);
  CHECK(contains(message_of([&] { choose_views(views, points, "z", "c.json"); }), "3 of 4 cameras"));
}

TEST_CASE("cameras: no view is chosen twice, even when all stand on one side") {
  std::vector<CapturedView> views;
  for (double x : {-1.5, -0.5, 0.5, 1.5})
    views.push_back({fmt::format("{}", x), look_at({x, -5, 0}, {0, 0, 0}, {0, 0, 1}, 1, 64, 64)});
  const auto chosen = choose_views(views, {{0, 0, 0}, {1, 1, 1}}, "z", "c.json");
  std::array<bool, 4> used = {};
  for (const ChosenView& view : chosen) used[view.index] = true;
  CHECK(used == std::array<bool, 4>{true, true, true, true});
  CHECK(chosen[3].index == 0);  // the leftmost is the left view
  CHECK(chosen[1].index == 3);
}
