#include "bundle/captured_views.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "bundle/foreign_json.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas::bundle {
namespace {

constexpr double kRigidTolerance = 1e-3;  // cameras.json and transforms.json are often written as float32
constexpr size_t kMaxModelBytes = size_t{1} << 30;

bool is_splatting_list(const Json& document) {
  return document.is_array() && !document.empty() && document[0].is_object() && document[0].contains("rotation") &&
         document[0].contains("position");
}

// The folder of the COLMAP model that `path` means; empty when it means something else.
std::string colmap_folder(const std::string& path) {
  std::error_code failure;
  if (fs::is_directory(path, failure)) return path;
  const std::string name = fs::path(path).filename().string();
  const bool part = name == "cameras.txt" || name == "cameras.bin" || name == "images.txt" || name == "images.bin";
  return part ? folder_of(path) : "";
}

// With the paths only.
ColmapFiles find_colmap(const std::string& folder) {
  for (const char* ending : {".bin", ".txt"}) {
    ColmapFiles files;
    files.cameras_path = folder + "/cameras" + ending;
    files.images_path = folder + "/images" + ending;
    std::error_code failure;
    if (!fs::is_regular_file(files.cameras_path, failure) || !fs::is_regular_file(files.images_path, failure)) continue;
    files.binary = std::string(ending) == ".bin";
    return files;
  }
  throw invalid_input({folder, "", "no COLMAP model", "cameras and images, both .bin or both .txt",
                       "it is often in a folder sparse/0"});
}

}  // namespace

Camera camera_at_pose(const Eigen::Matrix3d& camera_to_world, const Eigen::Vector3d& position, const std::string& file,
                      const std::string& field) {
  const bool rigid =
      (camera_to_world.transpose() * camera_to_world - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <
          kRigidTolerance &&
      camera_to_world.determinant() > 0;
  if (!rigid || !position.allFinite()) {
    throw invalid_input({file, field, "a matrix that is no rotation", "a rotation with determinant +1 and a position"});
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(camera_to_world, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = (svd.matrixU() * svd.matrixV().transpose()).transpose();
  Camera camera;
  camera.world_to_camera.topLeftCorner<3, 3>() = R;
  camera.world_to_camera.topRightCorner<3, 1>() = -R * position;
  return camera;
}

std::vector<CapturedView> views_from_splatting(const Json& document, const std::string& file) {
  std::vector<CapturedView> views;
  for (size_t i = 0; i < document.size(); ++i) {
    const std::string pointer = fmt::format("/{}", i);
    const ForeignObject entry(document[i], file, pointer);
    CapturedView view;
    view.image = entry.text("img_name");
    view.camera =
        camera_at_pose(entry.matrix("rotation", 3, 3), entry.vector("position"), file, entry.where("rotation"));
    view.camera.width = entry.pixels("width");
    view.camera.height = entry.pixels("height");
    view.camera.fx = entry.positive("fx");
    view.camera.fy = entry.positive("fy");
    view.camera.cx = 0.5 * view.camera.width;
    view.camera.cy = 0.5 * view.camera.height;
    views.push_back(std::move(view));
  }
  return views;
}

bool is_captured_json(const Json& document) {
  return is_splatting_list(document) || is_exported_list(document) || is_world_to_camera_list(document) ||
         (document.is_object() && document.contains("frames"));
}

std::vector<CapturedView> captured_views_from(const Json& document, const std::string& file,
                                              const ImageSize& image_size) {
  if (is_splatting_list(document)) return views_from_splatting(document, file);
  if (is_exported_list(document)) return views_from_exported(document, file, image_size);
  if (is_world_to_camera_list(document)) return views_from_world_to_camera(document, file, image_size);
  if (is_captured_json(document)) return views_from_transforms(document, file, image_size);
  throw invalid_input(
      {file, "/", "JSON of another kind",
       "a list of {name, image, camera}, a transforms.json with frames, a 3DGS cameras.json, or poses of ns-export"});
}

std::vector<std::string> captured_view_files(const std::string& path) {
  const std::string folder = colmap_folder(path);
  if (folder.empty()) return {path};
  const ColmapFiles files = find_colmap(folder);
  return {files.cameras_path, files.images_path};
}

std::vector<CapturedView> load_captured_views(const std::string& path, const ImageSize& image_size) {
  const std::string folder = colmap_folder(path);
  if (folder.empty()) return captured_views_from(parse_json(read_file(path), path), path, image_size);
  ColmapFiles files = find_colmap(folder);
  files.cameras = read_file(files.cameras_path, kMaxModelBytes);
  files.images = read_file(files.images_path, kMaxModelBytes);
  return views_from_colmap(files);
}

}  // namespace physmas::bundle
