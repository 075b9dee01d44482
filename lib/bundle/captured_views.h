// Calibrated images as other programs list them: nerfstudio and Blender, COLMAP, 3D Gaussian Splatting, scripts.
#ifndef PHYSMAS_BUNDLE_CAPTURED_VIEWS_H
#define PHYSMAS_BUNDLE_CAPTURED_VIEWS_H

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "bundle/distortion.h"
#include "records/json_fwd.h"
#include "scene/camera.h"

namespace physmas::bundle {

struct CapturedView {
  std::string image;  // as the file names it: relative, perhaps without extension
  Camera camera;      // scene units; what a pinhole would see
  Distortion distortion = {};
  bool trained_frame = false;  // nerfstudio's: its dataparser has moved it already
};

// Width and height of the image of that name, for files that do not tell.
using ImageSize = std::function<std::pair<int, int>(const std::string& image)>;

// The views of FILE in its order: `transforms.json` (nerfstudio, instant-ngp, Blender), `cameras.json` (Kerbl et al.
// 2023), the list of `ns-export cameras`, world-to-camera matrices, or a COLMAP model (its folder, or its cameras.txt,
// cameras.bin, images.txt or images.bin). Told apart by what is in them. At least one view; every camera is rigid, and
// its lens perspective. Errors (exit code 3) name the file, the field or line, and, for fisheyes and other lenses, how
// to undistort.
std::vector<CapturedView> load_captured_views(const std::string& path, const ImageSize& image_size);

// The files that load_captured_views reads for `path`: itself, or the two of a COLMAP model.
std::vector<std::string> captured_view_files(const std::string& path);

// The same as load_captured_views for JSON that is already parsed, and whether it is one of those two kinds.
bool is_captured_json(const Json& document);
std::vector<CapturedView> captured_views_from(const Json& document, const std::string& file,
                                              const ImageSize& image_size);

// One reader per kind.
// transforms.json: camera-to-world matrices with OpenGL axes; w, h, fl_x, fl_y, cx, cy, k1.. for all or per frame;
// focal lengths from camera_angle_x, camera_angle_y when absent; applied_transform (3 x 4) and applied_scale are
// undone, so that cameras stand where the capture had them.
std::vector<CapturedView> views_from_transforms(const Json& document, const std::string& file,
                                                const ImageSize& image_size);
// cameras.json: position and camera-to-world rotation with OpenCV axes, fx, fy, width, height; principal point in the
// middle.
std::vector<CapturedView> views_from_splatting(const Json& document, const std::string& file);
// World-to-camera matrices with OpenCV axes, 3 or 4 rows of 4, under w2c, world_to_camera or extrinsic(s), in a list or
// in `frames`; fx fy cx cy or fl_x fl_y, or a matrix K, and w h or width height, for all or per entry.
bool is_world_to_camera_list(const Json& document);
std::vector<CapturedView> views_from_world_to_camera(const Json& document, const std::string& file,
                                                     const ImageSize& image_size);
// What `ns-export cameras` writes: camera-to-world matrices with OpenGL axes in nerfstudio's own frame, and no lens,
// which is taken from a transforms.json beside the list.
bool is_exported_list(const Json& document);
std::vector<CapturedView> views_from_exported(const Json& document, const std::string& file,
                                              const ImageSize& image_size);
// COLMAP, from the bytes of its cameras and images files (text, or binary). Pinholes and radial or tangential
// distortion; no fisheyes.
struct ColmapFiles {
  std::string cameras_path, images_path;  // for messages
  std::string cameras, images;            // bytes
  bool binary = false;
};
std::vector<CapturedView> views_from_colmap(const ColmapFiles& files);

// A camera from its camera-to-world rotation (columns: its x, y, z axes; OpenCV) and position. The rotation may be off
// by rounding (1e-3) and is made orthonormal. Throws an Error naming file and field when it is none.
Camera camera_at_pose(const Eigen::Matrix3d& camera_to_world, const Eigen::Vector3d& position, const std::string& file,
                      const std::string& field);

}  // namespace physmas::bundle

#endif
