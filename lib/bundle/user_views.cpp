#include "bundle/user_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "bundle/choose_views.h"
#include "bundle/dataparser_transform.h"
#include "bundle/view_rig.h"
#include "records/json.h"
#include "scene/image_file.h"

namespace fs = std::filesystem;

namespace physmas::bundle {
namespace {

constexpr double kFarOff = 45;  // degrees: nearer to another of the four directions

UserViews read_own_list(const Json& list, const std::string& cameras, const std::string& folder,
                        const std::optional<DataparserTransform>& turning, const std::string& bundle) {
  if (!list.is_array())
    throw invalid_input({cameras, "/", "JSON that is not a list", "a list of four {name, image, camera}"});
  if (list.size() != 4)
    throw invalid_input({cameras, "/", fmt::format("{} views", list.size()), "exactly four {name, image, camera}"});
  // The list is what scene.json has as `views`, so its schema judges it.
  validate_record({{"schema", "physmas/scene/1"}, {"name", "cameras"}, {"views", list}}, "scene", cameras);
  UserViews user;
  std::set<std::string> names;
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string pointer = "/" + std::to_string(i);
    SceneView view;
    view.name = list[i].at("name").get<std::string>();
    if (!names.insert(view.name).second)
      throw invalid_field(cameras, pointer + "/name", view.name, "a name of its own for each view");
    view.camera = camera_from(list[i].at("camera"), cameras, pointer + "/camera");
    if (turning) turning->apply(view.camera);
    const std::string source =
        resolve_inside(folder, list[i].at("image").get<std::string>(), cameras, pointer + "/image");
    const Image image = load_image(source);
    if (image.width != view.camera.width || image.height != view.camera.height) {
      throw invalid_input({source, "", fmt::format("an image of {} x {} pixels", image.width, image.height),
                           fmt::format("{} x {} as its camera says", view.camera.width, view.camera.height)});
    }
    view.image = bundle + "/views/" + view.name + fs::path(source).extension().string();
    user.files.push_back({view.image, read_file(source)});
    user.views.push_back(std::move(view));
  }
  return user;
}

// The file of an image: under its whole name or its last part, with an extension where it lacks one.
std::string find_image(const std::string& folder, const std::string& name, const std::string& cameras) {
  std::string slashes = name;  // of a path that Windows wrote
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  const auto last = [](const std::string& path) { return fs::path(path).filename().string(); };
  for (const std::string& candidate : {name, last(name), slashes, last(slashes)}) {
    const std::string normal = fs::path(candidate).lexically_normal().generic_string();
    if (normal.empty() || normal[0] == '/' || normal.rfind("..", 0) == 0) continue;
    for (const char* extension : {"", ".png", ".jpg", ".jpeg", ".PNG", ".JPG"}) {
      const std::string file = folder + "/" + normal + extension;
      std::error_code failure;
      if (fs::is_regular_file(file, failure)) return file;
    }
  }
  throw invalid_input({cameras, "", "the image \"" + one_line(name, 200) + "\"", "one that lies in " + folder,
                       "--views DIR is the folder with the images"});
}

bool is_named(std::string name, const std::string& wanted) {
  if (name == wanted) return true;
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path path(name);
  return name == wanted || path.filename() == wanted || path.stem() == wanted;
}

// The index of the view that --front names.
template <class Views, class NameOf>
int named_view(const Views& views, const NameOf& name_of, const std::string& front, const std::string& cameras) {
  for (size_t i = 0; i < views.size(); ++i) {
    if (is_named(name_of(views[i]), front)) return static_cast<int>(i);
  }
  throw Error(
      ExitCode::usage,
      fmt::format("--front: found \"{}\", expected x, y, z, -x, -y or -z, degrees from -360 to 360, or a view of {}",
                  one_line(front, 80), cameras));
}

void put_front_first(UserViews& user, const std::string& front, const std::optional<double>& degrees,
                     const Eigen::Vector3d& center, const std::string& up, const std::string& cameras) {
  size_t first = 0;
  if (!degrees) {
    first = named_view(
        user.views, [](const SceneView& view) { return view.name; }, front, cameras);
  } else {
    const auto off = [&](const SceneView& view) {
      return std::abs(std::remainder(azimuth_of(view.camera, center, up) - *degrees, 360));
    };
    for (size_t i = 1; i < user.views.size(); ++i) {
      if (off(user.views[i]) < off(user.views[first]) - 1e-9) first = i;
    }
  }
  std::rotate(user.views.begin(), user.views.begin() + static_cast<std::ptrdiff_t>(first), user.views.end());
  user.front = azimuth_of(user.views[0].camera, center, up);
}

Camera scaled_to(Camera camera, const Image& image, const std::string& file) {
  const double x = static_cast<double>(image.width) / camera.width,
               y = static_cast<double>(image.height) / camera.height;
  // Programs that shrink images round both sides.
  if (std::abs(image.height - camera.height * x) > 1 && std::abs(image.width - camera.width * y) > 1) {
    throw invalid_input({file, "", fmt::format("an image of {} x {} pixels", image.width, image.height),
                         fmt::format("{} x {} as its camera says, or a scaled copy", camera.width, camera.height)});
  }
  camera.fx *= x, camera.cx *= x, camera.fy *= y, camera.cy *= y;
  camera.width = image.width, camera.height = image.height;
  return camera;
}

}  // namespace

UserViews read_user_views(const std::string& cameras, const std::string& folder, const std::string& dataparser,
                          const DataparserTransform& placing, const std::vector<Eigen::Vector3d>& points,
                          const std::string& up, const std::string& front, const std::string& bundle) {
  const std::optional<double> degrees = front.empty() ? 0 : front_degrees(front, up);
  const ImageSize size_of = [&](const std::string& name) {
    const Image image = load_image(find_image(folder, name, cameras));
    return std::make_pair(image.width, image.height);
  };
  std::optional<DataparserTransform> turning;  // none keeps cameras bit for bit
  if (placing.rotation != Eigen::Matrix3d::Identity() || !placing.translation.isZero()) turning = placing;
  std::vector<CapturedView> captured;
  if (fs::path(cameras).extension() == ".json") {
    const Json document = parse_json(read_file(cameras), cameras);
    if (!is_captured_json(document)) {
      UserViews user = read_own_list(document, cameras, folder, turning, bundle);
      if (!front.empty()) put_front_first(user, front, degrees, middle_of(points), up, cameras);
      return user;
    }
    captured = captured_views_from(document, cameras, size_of);
  } else {
    captured = load_captured_views(cameras, size_of);
  }
  const bool moved = !dataparser.empty() && !captured.front().trained_frame;
  if (moved) {
    const DataparserTransform transform = load_dataparser_transform(dataparser);
    for (CapturedView& view : captured) transform.apply(view.camera);
  }
  for (CapturedView& view : captured) {
    if (turning) turning->apply(view.camera);
  }
  UserViews user;
  user.front = degrees.value_or(0);
  int front_view = -1;
  if (!degrees) {
    front_view = named_view(
        captured, [](const CapturedView& view) { return view.image; }, front, cameras);
    user.front = azimuth_of(captured[front_view].camera, middle_of(points), up);
  }
  const std::array<ChosenView, 4> chosen = choose_views(captured, points, up, cameras, user.front, front_view);
  user.transformed = moved;
  for (size_t side = 0; side < chosen.size(); ++side) {
    const CapturedView& from = captured[chosen[side].index];
    const std::string source = find_image(folder, from.image, cameras);
    SceneView view;
    view.name = kViewNames[side];
    const Image image = load_image(source);
    view.camera = scaled_to(from.camera, image, source);
    const bool distorted = !from.distortion.none();
    view.image = bundle + "/views/" + view.name + (distorted ? ".png" : fs::path(source).extension().string());
    user.chosen.emplace_back(view.name,
                             fmt::format("{}, {:.1f} degrees off", one_line(from.image, 200), chosen[side].angle));
    if (chosen[side].angle > kFarOff) {
      log_warning(fmt::format("{}: no camera near the {} view; the nearest free one is {}", cameras, view.name,
                              user.chosen.back().second));
    }
    user.files.push_back(
        {view.image, distorted ? encode_png(undistorted(image, view.camera, from.distortion)) : read_file(source)});
    user.views.push_back(std::move(view));
  }
  return user;
}

}  // namespace physmas::bundle
