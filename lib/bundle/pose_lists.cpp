// Poses as scripts and `ns-export cameras` list them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "bundle/captured_views.h"
#include "bundle/foreign_json.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas::bundle {
namespace {

// What names a world-to-camera matrix, OpenCV axes.
constexpr const char* kWorldToCamera[] = {"w2c", "world_to_camera", "extrinsic", "extrinsics"};
constexpr const char* kIntrinsics[] = {"K", "intrinsic", "intrinsics"};

const char* key_among(const Json& object, const char* const* begin, const char* const* end) {
  const char* const* found = std::find_if(begin, end, [&](const char* key) { return object.contains(key); });
  return found == end ? nullptr : *found;
}
const char* world_to_camera_key(const Json& entry) {
  return entry.is_object() ? key_among(entry, std::begin(kWorldToCamera), std::end(kWorldToCamera)) : nullptr;
}

// The entries of a list, or of the list `frames`.
const Json* entries_of(const Json& document) {
  const Json* list = &document;
  if (document.is_object() && document.contains("frames")) list = &document.at("frames");
  return list->is_array() && !list->empty() ? list : nullptr;
}

std::string name_of(const ForeignObject& entry) {
  for (const char* key : {"file_path", "image", "img_name", "name"}) {
    if (entry.has(key)) return entry.text(key);
  }
  throw entry.error("file_path", "the name of the image");
}

// Size, focal lengths and principal point from the entry, else from the document; true when there was a focal length.
bool read_lens(const ForeignObject& entry, const ForeignObject& all, const std::string& image,
               const ImageSize& image_size, Camera& camera) {
  const auto owner = [&](const char* key) -> const ForeignObject& { return entry.has(key) ? entry : all; };
  const auto first = [&](std::initializer_list<const char*> keys) -> std::string {
    for (const char* key : keys) {
      if (owner(key).has(key)) return key;
    }
    return "";
  };
  const std::string w = first({"w", "width"}), h = first({"h", "height"});
  if (!w.empty() && !h.empty()) {
    camera.width = owner(w.c_str()).pixels(w);
    camera.height = owner(h.c_str()).pixels(h);
  } else {
    std::tie(camera.width, camera.height) = image_size(image);
  }
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  const char* matrix = key_among(entry.json(), std::begin(kIntrinsics), std::end(kIntrinsics));
  const ForeignObject& with_matrix = matrix != nullptr ? entry : all;
  if (matrix == nullptr) matrix = key_among(all.json(), std::begin(kIntrinsics), std::end(kIntrinsics));
  if (matrix != nullptr) {
    const Eigen::MatrixXd K = with_matrix.matrix(matrix, 3, 3);
    if (!(K(0, 0) > 0 && K(1, 1) > 0)) throw with_matrix.error(matrix, "focal lengths above 0 on its diagonal");
    camera.fx = K(0, 0), camera.fy = K(1, 1), camera.cx = K(0, 2), camera.cy = K(1, 2);
    return true;
  }
  const std::string fx = first({"fx", "fl_x"}), fy = first({"fy", "fl_y"});
  if (fx.empty() && fy.empty()) return false;
  if (!fx.empty()) camera.fx = owner(fx.c_str()).positive(fx);
  camera.fy = fy.empty() ? camera.fx : owner(fy.c_str()).positive(fy);
  if (fx.empty()) camera.fx = camera.fy;
  camera.cx = owner("cx").number("cx", camera.cx);
  camera.cy = owner("cy").number("cy", camera.cy);
  return true;
}

Json no_object() {
  return Json::object();
}

}  // namespace

bool is_world_to_camera_list(const Json& document) {
  const Json* list = entries_of(document);
  return list != nullptr && world_to_camera_key(list->front()) != nullptr;
}

std::vector<CapturedView> views_from_world_to_camera(const Json& document, const std::string& file,
                                                     const ImageSize& image_size) {
  const Json& list = *entries_of(document);
  const Json none = no_object();
  const ForeignObject all(document.is_object() ? document : none, file, "");
  const std::string place = document.is_object() ? "/frames" : "";
  std::vector<CapturedView> views;
  for (size_t i = 0; i < list.size(); ++i) {
    const ForeignObject entry(list[i], file, fmt::format("{}/{}", place, i));
    const char* key = world_to_camera_key(list[i]);
    if (key == nullptr) throw entry.error("w2c", "a world-to-camera matrix, as the first entry has");
    const Eigen::MatrixXd matrix = entry.matrix(key, 3, 4);
    const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
    CapturedView view;
    view.image = name_of(entry);
    view.camera = camera_at_pose(R.transpose(), -R.transpose() * matrix.col(3), file, entry.where(key));
    if (!read_lens(entry, all, view.image, image_size, view.camera))
      throw entry.error("fx", "a focal length in pixels, fx or fl_x, or a matrix K");
    views.push_back(std::move(view));
  }
  return views;
}

bool is_exported_list(const Json& document) {
  return document.is_array() && !document.empty() && document[0].is_object() && document[0].contains("file_path") &&
         document[0].contains("transform");
}

std::vector<CapturedView> views_from_exported(const Json& document, const std::string& file,
                                              const ImageSize& image_size) {
  // The list has poses alone. The lens is that of the capture, whose transforms.json may lie beside it.
  const std::string lens_file = join_path(folder_of(file), "transforms.json");
  std::error_code failure;
  Json lens = no_object();
  const bool beside = fs::is_regular_file(lens_file, failure);
  if (beside) lens = parse_json(read_file(lens_file), lens_file);
  const ForeignObject all(lens, lens_file, "");
  bool known = true;
  std::vector<CapturedView> views;
  for (size_t i = 0; i < document.size(); ++i) {
    const ForeignObject entry(document[i], file, fmt::format("/{}", i));
    const Eigen::MatrixXd matrix = entry.matrix("transform", 3, 4);
    Eigen::Matrix3d axes = matrix.topLeftCorner<3, 3>();
    axes.rightCols<2>() *= -1;  // OpenGL looks along -z with y up
    CapturedView view;
    view.image = entry.text("file_path");
    view.trained_frame = true;
    view.camera = camera_at_pose(axes, matrix.col(3), file, entry.where("transform"));
    if (!read_lens(entry, all, view.image, image_size, view.camera)) {
      known = false;
      // What COLMAP begins with where a picture does not say it.
      view.camera.fx = view.camera.fy = 1.2 * std::max(view.camera.width, view.camera.height);
    }
    views.push_back(std::move(view));
  }
  if (!known) {
    log_warning(file +
                ": the list has no focal length: 1.2 times the longer side is taken; put the capture's transforms.json "
                "beside it, which has it");
  }
  return views;
}

}  // namespace physmas::bundle
