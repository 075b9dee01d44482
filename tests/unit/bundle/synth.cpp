#include "bundle/synth.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "bundle/synth_bundle.h"
#include "records/hdf5_file.h"
#include "records/scene.h"
#include "scene/gaussian_files.h"

using namespace physmas;
using namespace physmas::bundle;

namespace {

const char kBallOnBox[] = R"({
  "schema": "physmas/example/1", "name": "tiny", "prompt": "it falls", "seed": 5, "spacing": 0.1,
  "floor": {"height": -0.5},
  "objects": [{"id": "toy", "name": "toy", "parts": [
    {"part": "ball", "name": "ball", "shapes": [
      {"type": "sphere", "radius": 0.5, "center": [0, 0, 1.5], "color": [0.9, 0.1, 0.1]}]},
    {"part": "box", "name": "box", "shapes": [
      {"type": "box", "size": [2, 1, 1], "center": [0, 0, 0.5], "color": [0.1, 0.1, 0.9], "color_jitter": 0}]}]}],
  "run": {"grid": {"n": 32}, "render": {"width": 64, "height": 64}}})";

std::string folder_for(const std::string& name) {
  const std::string folder = (std::filesystem::temp_directory_path() / ("physmas-unit-" + name)).string();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

SynthScene synthesize_text(const std::string& text) {
  const std::string file = folder_for("synth-text") + "/example.json";
  write_file(file, text);
  return synthesize(load_example(file), file);
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string failure_of(const std::string& text) {
  try {
    synthesize_text(text);
  } catch (const Error& e) {
    CHECK(e.code() == ExitCode::invalid_input);
    return e.what();
  }
  FAIL("accepted");
  return "";
}

void bounds(const SynthScene& scene, int row, Eigen::Vector3f& low, Eigen::Vector3f& high) {
  low.setConstant(1e9f);
  high = -low;
  for (size_t i = 0; i < scene.row.size(); ++i) {
    if (scene.row[i] != row) continue;
    low = low.cwiseMin(scene.gaussians.position[i]);
    high = high.cwiseMax(scene.gaussians.position[i]);
  }
}

}  // namespace

TEST_CASE("the same seed gives the same Gaussians, another seed others") {
  const SynthScene a = synthesize_text(kBallOnBox), b = synthesize_text(kBallOnBox);
  CHECK(a.gaussians.position == b.gaussians.position);
  CHECK(a.gaussians.rotation == b.gaussians.rotation);
  CHECK(a.gaussians.sh == b.gaussians.sh);
  const SynthScene c = synthesize_text(with(kBallOnBox, "\"seed\": 5", "\"seed\": 6"));
  CHECK(a.gaussians.position != c.gaussians.position);
}

TEST_CASE("values are multiples of 2^-20, so that rounding errors of a machine do not show") {
  const SynthScene scene = synthesize_text(kBallOnBox);
  for (const Eigen::Vector3f& p : scene.gaussians.position) {
    for (int axis = 0; axis < 3; ++axis) CHECK(std::nearbyint(p[axis] * 0x1p20) == p[axis] * 0x1p20);
  }
}

TEST_CASE("samples cover the described shapes evenly") {
  const SynthScene scene = synthesize_text(kBallOnBox);
  REQUIRE(scene.inventory.rows.size() == 2);
  REQUIRE(scene.row.size() == scene.gaussians.size());
  Eigen::Vector3f low, high;
  bounds(scene, 0, low, high);
  CHECK(low.x() == doctest::Approx(-0.5).epsilon(0.02));
  CHECK(high.z() == doctest::Approx(2.0).epsilon(0.01));
  for (size_t i = 0; i < scene.row.size(); ++i) {
    if (scene.row[i] != 0) continue;
    CHECK((scene.gaussians.position[i] - Eigen::Vector3f(0, 0, 1.5f)).norm() == doctest::Approx(0.5).epsilon(1e-3));
    // The thin axis is the third: along the radius.
    const Eigen::Vector3f normal = scene.gaussians.rotation_matrix(i).col(2);
    CHECK(std::abs(normal.dot((scene.gaussians.position[i] - Eigen::Vector3f(0, 0, 1.5f)).normalized())) > 0.99f);
  }
  bounds(scene, 1, low, high);
  CHECK(low.z() == 0);
  CHECK(high.x() == 1);
  // Area by spacing squared: pi for the ball, 10 for the box.
  const auto ball = std::count(scene.row.begin(), scene.row.end(), 0),
             box = std::count(scene.row.begin(), scene.row.end(), 1);
  CHECK(ball == doctest::Approx(314).epsilon(0.06));
  CHECK(box == doctest::Approx(1000).epsilon(0.02));
}

TEST_CASE("colours are those of the parts, darker in the shade") {
  const SynthScene scene = synthesize_text(kBallOnBox);
  for (size_t i = 0; i < scene.row.size(); ++i) {
    const Eigen::Vector3f color = (scene.gaussians.sh[i] * 0.28209479f).array() + 0.5f;
    const int strong = scene.row[i] == 0 ? 0 : 2;
    CHECK(color[strong] > 4 * color[1]);
    CHECK(color.maxCoeff() <= 1.001f);
  }
}

TEST_CASE("overlapping shapes of one part lose their hidden pieces") {
  const std::string sphere = R"({"type": "sphere", "radius": 0.5, "center": [0, 0, 1.5], "color": [0.9, 0.1, 0.1]})";
  const SynthScene scene = synthesize_text(
      with(kBallOnBox, sphere,
           sphere + R"(, {"type": "sphere", "radius": 0.3, "center": [0, 0, 1.5], "color": [1, 1, 1]})"));
  const SynthScene alone = synthesize_text(kBallOnBox);
  CHECK(std::count(scene.row.begin(), scene.row.end(), 0) == std::count(alone.row.begin(), alone.row.end(), 0));
}

TEST_CASE("up turns the scene") {
  const SynthScene z = synthesize_text(kBallOnBox);
  const SynthScene y = synthesize_text(with(kBallOnBox, "\"seed\": 5", "\"seed\": 5, \"up\": \"-y\""));
  REQUIRE(z.gaussians.size() == y.gaussians.size());
  for (size_t i = 0; i < z.gaussians.size(); ++i) {
    const Eigen::Vector3f &a = z.gaussians.position[i], &b = y.gaussians.position[i];
    CHECK(b.isApprox(Eigen::Vector3f(a.x(), -a.z(), a.y()), 1e-5f));
  }
}

TEST_CASE("a wrong example says what is wrong") {
  CHECK(failure_of(with(kBallOnBox, "\"radius\": 0.5, ", "")).find("/objects/0/parts/0/shapes/0/radius") !=
        std::string::npos);
  CHECK(
      failure_of(with(kBallOnBox, "\"radius\": 0.5", "\"radius\": 0.5, \"height\": 1")).find("a sphere takes radius") !=
      std::string::npos);
  CHECK(failure_of(with(kBallOnBox, "\"part\": \"box\"", "\"part\": \"ball\"")).find("/objects/0/parts/1/part") !=
        std::string::npos);
  CHECK(failure_of(with(kBallOnBox, "it falls", "  ")).find("/prompt") != std::string::npos);
  CHECK(failure_of(with(kBallOnBox, "\"seed\": 5", "\"sed\": 5")).find("sed") != std::string::npos);
  CHECK(failure_of(with(kBallOnBox, "\"spacing\": 0.1", "\"spacing\": 1e-5")).find("/spacing") != std::string::npos);
}

TEST_CASE("a synthesised bundle can be read back, and its floor lies where the example says") {
  const std::string folder = folder_for("synth-bundle");
  write_file(folder + "/example.json", kBallOnBox);
  bundle::write_synth_bundle(folder + "/example.json", folder + "/out");
  const Scene scene = load_scene(folder + "/out/scene.json", {true, true, true, true});
  CHECK(scene.prompt == "it falls");
  REQUIRE(scene.run.colliders.size() == 1);
  const Gaussians gaussians = load_gaussians(scene.gaussians);
  // Two units high and wide: s = 0.5, centre at z = 1, so z = -0.5 becomes 1 - 0.5 * 1.5.
  CHECK(scene.run.colliders[0].point.z() == doctest::Approx(0.25).epsilon(0.005));
  const Hdf5Reader truth(folder + "/out/truth.h5", "truth");
  CHECK(truth.read_int("/gaussians/row", {gaussians.size()}).size() == gaussians.size());
  const Inventory inventory = load_inventory(scene.inventory);
  for (const InventoryRow& row : inventory.rows) CHECK_FALSE(row.hints.colors.empty());
  const auto before = std::filesystem::last_write_time(folder + "/out/scene.json");
  bundle::write_synth_bundle(folder + "/example.json", folder + "/out");
  CHECK(std::filesystem::last_write_time(folder + "/out/scene.json") == before);
}
