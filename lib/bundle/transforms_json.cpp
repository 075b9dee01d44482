#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "base/constants.h"
#include "base/error.h"
#include "bundle/captured_views.h"
#include "bundle/foreign_json.h"
#include "records/json.h"

namespace physmas::bundle {
namespace {

constexpr const char* kUndistort =
    "undistort the images first, for example with COLMAP's image_undistorter, and import its model";

// A number of the frame, else of the whole file.
class Lens {
 public:
  Lens(const ForeignObject& frame, const ForeignObject& all) : frame_(frame), all_(all) {}
  bool has(const char* key) const { return frame_.has(key) || all_.has(key); }
  const ForeignObject& owner(const char* key) const { return frame_.has(key) ? frame_ : all_; }
  double number(const char* key, double absent) const { return owner(key).number(key, absent); }

 private:
  const ForeignObject& frame_;
  const ForeignObject& all_;
};

void require_perspective(const Lens& lens) {
  if (lens.has("camera_model")) {
    const ForeignObject& owner = lens.owner("camera_model");
    const std::string model = owner.text("camera_model");
    bool known = false;
    for (const char* name : {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV"}) {
      known |= model == name;
    }
    if (!known) throw owner.error("camera_model", "a perspective lens (PINHOLE, OPENCV)", kUndistort);
  }
  if (lens.has("is_fisheye") && lens.owner("is_fisheye").json().at("is_fisheye") == true) {
    throw lens.owner("is_fisheye").error("is_fisheye", "a perspective lens", kUndistort);
  }
  // nerfstudio's k4 belongs to r^8, OpenCV's is a denominator.
  for (const char* key : {"k4", "k5", "k6"}) {
    if (lens.number(key, 0) != 0) throw lens.owner(key).error(key, "0", kUndistort);
  }
}

double focal_length(const Lens& lens, const char* length, const char* angle, int size) {
  if (lens.has(length)) return lens.owner(length).positive(length);
  if (!lens.has(angle)) return 0;
  const double value = lens.owner(angle).positive(angle);
  if (value >= kPi) throw lens.owner(angle).error(angle, "an angle below pi, in radians");
  return 0.5 * size / std::tan(0.5 * value);
}

// Inverse of the affine map that was applied to all poses.
Eigen::Matrix4d undo(const ForeignObject& all) {
  Eigen::Matrix4d applied = Eigen::Matrix4d::Identity();
  if (!all.has("applied_transform")) return applied;
  applied.topRows<3>() = all.matrix("applied_transform", 3, 4);
  const Eigen::Matrix3d A = applied.topLeftCorner<3, 3>();
  // A reflection or a scale would not leave the cameras rigid.
  if (!(A.transpose() * A).isIdentity(1e-3) || A.determinant() < 0) {
    throw all.error("applied_transform", "a rotation and a translation");
  }
  return applied.inverse();
}

// The factor that was applied to all positions after that.
double applied_scale(const ForeignObject& all) {
  return all.has("applied_scale") ? all.positive("applied_scale") : 1;
}

}  // namespace

std::vector<CapturedView> views_from_transforms(const Json& document, const std::string& file,
                                                const ImageSize& image_size) {
  const ForeignObject all(document, file, "");
  const Json& frames = document.at("frames");
  if (!frames.is_array() || frames.empty()) throw all.error("frames", "a list with at least one frame");
  const Eigen::Matrix4d undone = undo(all);
  const double scale = applied_scale(all);
  std::vector<CapturedView> views;
  for (size_t i = 0; i < frames.size(); ++i) {
    const ForeignObject frame(frames[i], file, fmt::format("/frames/{}", i));
    const Lens lens(frame, all);
    require_perspective(lens);
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose.topRows<3>() = frame.matrix("transform_matrix", 3, 4);
    pose.topRightCorner<3, 1>() /= scale;
    pose = undone * pose;
    Eigen::Matrix3d axes = pose.topLeftCorner<3, 3>();
    axes.rightCols<2>() *= -1;  // OpenGL looks along -z with y up
    CapturedView view;
    view.image = frame.text("file_path");
    view.camera = camera_at_pose(axes, pose.topRightCorner<3, 1>(), file, frame.where("transform_matrix"));
    Camera& camera = view.camera;
    if (lens.has("w") && lens.has("h")) {
      camera.width = lens.owner("w").pixels("w");
      camera.height = lens.owner("h").pixels("h");
    } else {
      std::tie(camera.width, camera.height) = image_size(view.image);
    }
    camera.fx = focal_length(lens, "fl_x", "camera_angle_x", camera.width);
    camera.fy = focal_length(lens, "fl_y", "camera_angle_y", camera.height);
    if (camera.fx == 0 && camera.fy == 0) throw all.error("fl_x", "fl_x or camera_angle_x, for all or per frame");
    if (camera.fx == 0) camera.fx = camera.fy;
    if (camera.fy == 0) camera.fy = camera.fx;
    camera.cx = lens.number("cx", 0.5 * camera.width);
    camera.cy = lens.number("cy", 0.5 * camera.height);
    view.distortion = {lens.number("k1", 0), lens.number("k2", 0), lens.number("k3", 0), lens.number("p1", 0),
                       lens.number("p2", 0)};
    require_unfolded(view.distortion, camera, file, lens.owner("k1").where("k1"));
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace physmas::bundle
