#include "records/cameras.h"

#include <cmath>

#include "records/json.h"
#include "records/run_fields.h"

namespace physmas {
namespace {

PictureReach reach_from(const Json& json) {
  return {json.at("right").get<double>(), json.at("left").get<double>(), json.at("down").get<double>(),
          json.at("up").get<double>()};
}

Json to_json(const PictureReach& reach) {
  const auto number = [](double v) { return std::isfinite(v) ? v : 0; };
  return {{"right", number(reach.right)},
          {"left", number(reach.left)},
          {"down", number(reach.down)},
          {"up", number(reach.up)}};
}

}  // namespace

FittedCameras load_cameras(const std::string& path) {
  const Json document = load_record(path, "cameras");
  FittedCameras fitted;
  fitted.mode =
      static_cast<RunSpecification::Render::CameraMode>(index_of(kCameraModes, document.at("mode").get<std::string>()));
  for (const Json& camera : document.at("cameras")) {
    fitted.cameras.push_back(camera_from(camera, path, "/cameras/" + std::to_string(fitted.cameras.size())));
  }
  fitted.distance = document.at("distance").get<double>();
  fitted.reach = reach_from(document.at("reach"));
  fitted.rest = reach_from(document.at("rest"));
  fitted.candidates = document.at("candidates").get<std::vector<std::string>>();
  fitted.omitted = omissions_from(document);
  return fitted;
}

void save_cameras(const std::string& path, const FittedCameras& fitted, const Provenance& provenance) {
  Json json;
  json["mode"] = kCameraModes[static_cast<size_t>(fitted.mode)];
  json["distance"] = fitted.distance;
  json["candidates"] = fitted.candidates;
  json["reach"] = to_json(fitted.reach);
  json["rest"] = to_json(fitted.rest);
  json["cameras"] = Json::array();
  for (const Camera& camera : fitted.cameras) json["cameras"].push_back(to_json(camera));
  json["omitted"] = physmas::to_json(fitted.omitted);
  save_record(path, "cameras", provenance, json);
}

}  // namespace physmas
