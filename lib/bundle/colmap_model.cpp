#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

#include "base/error.h"
#include "bundle/captured_views.h"

namespace physmas::bundle {
namespace {

constexpr int kMaxSize = 32768;  // pixels of an image's edge
constexpr size_t kMaxNameBytes = 4096;

// COLMAP's camera models (colmap/sensor/models.h). Parameters start with the focal lengths and the principal point;
// whatever follows is distortion, of perspective models k1, or k1 k2, or k1 k2 p1 p2, or that and k3 k4 k5 k6.
struct Model {
  const char* name;
  int id, focal_lengths, parameters;
  bool perspective;
};
constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", 0, 1, 3, true},
    {"PINHOLE", 1, 2, 4, true},
    {"SIMPLE_RADIAL", 2, 1, 4, true},
    {"RADIAL", 3, 1, 5, true},
    {"OPENCV", 4, 2, 8, true},
    {"OPENCV_FISHEYE", 5, 2, 8, false},
    {"FULL_OPENCV", 6, 2, 12, true},
    {"FOV", 7, 2, 5, false},
    {"SIMPLE_RADIAL_FISHEYE", 8, 1, 4, false},
    {"RADIAL_FISHEYE", 9, 1, 5, false},
    {"THIN_PRISM_FISHEYE", 10, 2, 12, false},
};
constexpr const char* kUndistort = "run colmap image_undistorter and import the images and the model that it writes";

struct Lens {
  Camera camera;  // its pose left open
  Distortion distortion;
};

// parameters: p. where: line or byte, for messages.
Lens lens_from(const Model& model, double width, double height, const std::vector<double>& p, const std::string& file,
               const std::string& where) {
  const auto refuse = [&](const std::string& found, const std::string& expected, const std::string& fix = "") {
    return invalid_input({file, where, found, expected, fix});
  };
  if (!model.perspective) throw refuse(std::string("the camera model ") + model.name, "a perspective lens", kUndistort);
  if (!(width >= 1 && width <= kMaxSize && height >= 1 && height <= kMaxSize)) {
    throw refuse(fmt::format("{} x {} pixels", width, height), fmt::format("1 to {} pixels", kMaxSize));
  }
  for (double value : p) {
    if (!std::isfinite(value)) throw refuse("a parameter that is not finite", "numbers");
  }
  const size_t first = model.focal_lengths + 2;  // of the distortion
  const auto distortion = [&](size_t k) { return first + k < p.size() ? p[first + k] : 0; };
  for (size_t k = 5; k < 8; ++k) {
    if (distortion(k) != 0) throw refuse(fmt::format("{} with k{}", model.name, k - 1), "k4 to k6 of 0", kUndistort);
  }
  Camera camera;
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  camera.fx = p[0];
  camera.fy = p[model.focal_lengths - 1];
  camera.cx = p[model.focal_lengths];
  camera.cy = p[model.focal_lengths + 1];
  if (!(camera.fx > 0 && camera.fy > 0)) throw refuse("a focal length of 0 or below", "one above 0");
  const Distortion found = {distortion(0), distortion(1), distortion(4), distortion(2), distortion(3)};
  require_unfolded(found, camera, file, where);
  return {camera, found};
}

using Lenses = std::map<uint32_t, Lens>;

// q: w, x, y, z and t of the world-to-camera pose.
CapturedView view_from(const double* q, const double* t, uint32_t camera_id, const std::string& name,
                       const Lenses& lenses, const std::string& file, const std::string& where) {
  const auto lens = lenses.find(camera_id);
  if (lens == lenses.end()) {
    throw invalid_input({file, where, fmt::format("camera {}", camera_id), "a camera of the model's cameras file"});
  }
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) {
    throw invalid_input({file, where, fmt::format("a quaternion of length {:g}", rotation.norm()), "length 1"});
  }
  const Eigen::Matrix3d R = rotation.normalized().toRotationMatrix();
  CapturedView view;
  view.image = name;
  view.camera = camera_at_pose(R.transpose(), -R.transpose() * Eigen::Vector3d(t[0], t[1], t[2]), file, where);
  const Eigen::Matrix4d pose = view.camera.world_to_camera;
  view.camera = lens->second.camera;
  view.distortion = lens->second.distortion;
  view.camera.world_to_camera = pose;
  return view;
}

// Values of a binary model, little endian, with their end checked.
class Binary {
 public:
  Binary(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) {}

  template <class T>
  T next() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string next_name() {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos || end - at_ > kMaxNameBytes) {
      throw invalid_input({path_, where(), "a name without end", "a name that ends with a zero byte"});
    }
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }
  // A count of records of at least `each` bytes.
  uint64_t next_count(size_t each) {
    const std::string place = where();
    const uint64_t count = next<uint64_t>();
    if (count <= left() / each) return count;
    throw invalid_input({path_, place, fmt::format("{} records of {} bytes or more", count, each),
                         fmt::format("what fits {} bytes", left()), "the file may be cut off"});
  }
  void skip(size_t size) { need(size), at_ += size; }
  void finish() const {
    if (left() != 0) throw invalid_input({path_, where(), fmt::format("{} more bytes", left()), "the end of the file"});
  }
  std::string where() const { return fmt::format("byte {}", at_); }

 private:
  size_t left() const { return bytes_.size() - at_; }
  void need(size_t size) const {
    if (size <= left()) return;
    throw invalid_input(
        {path_, where(), fmt::format("{} bytes", left()), fmt::format("{} bytes", size), "the file may be cut off"});
  }

  const std::string& path_;
  const std::string& bytes_;
  size_t at_ = 0;
};

Lenses lenses_of_binary(const std::string& path, const std::string& bytes) {
  Binary file(path, bytes);
  Lenses lenses;
  const uint64_t count = file.next_count(24 + 3 * sizeof(double));
  for (uint64_t i = 0; i < count; ++i) {
    const std::string where = file.where();
    const auto id = file.next<uint32_t>();
    const auto model_id = file.next<int32_t>();
    const auto width = file.next<uint64_t>(), height = file.next<uint64_t>();
    const Model* model = nullptr;
    for (const Model& m : kModels) {
      if (m.id == model_id) model = &m;
    }
    if (model == nullptr) {
      throw invalid_input({path, where, fmt::format("camera model {}", model_id), "0 to 10", kUndistort});
    }
    std::vector<double> parameters;
    for (int k = 0; k < model->parameters; ++k) parameters.push_back(file.next<double>());
    const Lens lens =
        lens_from(*model, static_cast<double>(width), static_cast<double>(height), parameters, path, where);
    if (!lenses.emplace(id, lens).second) {
      throw invalid_input({path, where, fmt::format("camera {} twice", id), "every camera once"});
    }
  }
  file.finish();
  return lenses;
}

std::vector<CapturedView> views_of_binary(const std::string& path, const std::string& bytes, const Lenses& lenses) {
  Binary file(path, bytes);
  std::vector<CapturedView> views;
  const uint64_t count = file.next_count(4 + 7 * sizeof(double) + 4 + 1 + 8);
  for (uint64_t i = 0; i < count; ++i) {
    const std::string where = file.where();
    file.next<uint32_t>();  // the image's id
    double pose[7];
    for (double& value : pose) value = file.next<double>();
    const auto camera = file.next<uint32_t>();
    const std::string name = file.next_name();
    constexpr size_t kPointBytes = 24;
    file.skip(file.next_count(kPointBytes) * kPointBytes);
    views.push_back(view_from(pose, pose + 4, camera, name, lenses, path, where));
  }
  file.finish();
  return views;
}

// Lines with their numbers; comments are left out, empty lines are not (an image without points has one).
struct Line {
  int number;
  std::string text;
};
std::vector<Line> lines_of(const std::string& bytes) {
  std::vector<Line> lines;
  std::istringstream stream(bytes);
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.empty() || text[0] != '#') lines.push_back({number, text});
  }
  return lines;
}

bool blank(const std::string& text) {
  return text.find_first_not_of(" \t") == std::string::npos;
}

Lenses lenses_of_text(const std::string& path, const std::string& bytes) {
  Lenses lenses;
  for (const Line& line : lines_of(bytes)) {
    if (blank(line.text)) continue;
    const std::string where = fmt::format("line {}", line.number);
    std::istringstream words(line.text);
    uint32_t id = 0;
    std::string name;
    double width = 0, height = 0;
    if (!(words >> id >> name >> width >> height)) {
      throw invalid_input({path, where, "\"" + one_line(line.text, 60) + "\"", "CAMERA_ID MODEL WIDTH HEIGHT PARAMS"});
    }
    const Model* model = nullptr;
    for (const Model& m : kModels) {
      if (name == m.name) model = &m;
    }
    if (model == nullptr) {
      throw invalid_input(
          {path, where, "the camera model " + one_line(name, 60), "PINHOLE or SIMPLE_PINHOLE", kUndistort});
    }
    std::vector<double> parameters(model->parameters);
    for (double& value : parameters) words >> value;
    std::string more;
    if (!words || words >> more) {
      throw invalid_input(
          {path, where, "another number of parameters", fmt::format("{} for {}", model->parameters, model->name)});
    }
    if (!lenses.emplace(id, lens_from(*model, width, height, parameters, path, where)).second) {
      throw invalid_input({path, where, fmt::format("camera {} twice", id), "every camera once"});
    }
  }
  return lenses;
}

std::vector<CapturedView> views_of_text(const std::string& path, const std::string& bytes, const Lenses& lenses) {
  std::vector<CapturedView> views;
  const std::vector<Line> lines = lines_of(bytes);
  for (size_t i = 0; i < lines.size(); i += 2) {  // the second line of each image lists its points
    if (blank(lines[i].text)) {
      --i;  // a stray empty line between images
      continue;
    }
    const std::string where = fmt::format("line {}", lines[i].number);
    std::istringstream words(lines[i].text);
    uint32_t id = 0, camera = 0;
    double pose[7];
    words >> id;
    for (double& value : pose) words >> value;
    std::string name;
    if (!(words >> camera >> std::ws) || !std::getline(words, name) || name.empty()) {
      throw invalid_input(
          {path, where, "\"" + one_line(lines[i].text, 60) + "\"", "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"});
    }
    views.push_back(view_from(pose, pose + 4, camera, name, lenses, path, where));
  }
  return views;
}

}  // namespace

std::vector<CapturedView> views_from_colmap(const ColmapFiles& files) {
  const Lenses lenses = files.binary ? lenses_of_binary(files.cameras_path, files.cameras)
                                     : lenses_of_text(files.cameras_path, files.cameras);
  std::vector<CapturedView> views = files.binary ? views_of_binary(files.images_path, files.images, lenses)
                                                 : views_of_text(files.images_path, files.images, lenses);
  if (views.empty()) throw invalid_input({files.images_path, "", "no images", "at least one"});
  return views;
}

}  // namespace physmas::bundle
