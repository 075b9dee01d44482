#include "records/render.h"

#include "records/json.h"

namespace physmas {

namespace {

FrameForeground foreground_from(const Json& json, const std::string& path, const std::string& pointer) {
  FrameForeground frame;
  frame.frame = json.at("frame").get<int>();
  const Json& box = json.at("box");
  frame.present = !box.is_null();
  if (frame.present) {
    frame.x0 = box[0].get<int>(), frame.y0 = box[1].get<int>(), frame.x1 = box[2].get<int>(),
    frame.y1 = box[3].get<int>();
    if (frame.x1 <= frame.x0 || frame.y1 <= frame.y0)
      throw invalid_field(path, pointer + "/box", box, "x1 > x0 and y1 > y0");
  }
  frame.dark_ratio = json.at("dark_ratio").get<double>();
  frame.behind = json.value("behind", 0L);
  return frame;
}

std::vector<FrameForeground> foregrounds_from(const Json& list, const std::string& path, const std::string& pointer) {
  std::vector<FrameForeground> frames;
  for (const Json& json : list)
    frames.push_back(foreground_from(json, path, pointer + "/" + std::to_string(frames.size())));
  return frames;
}

Json foreground_json(const FrameForeground& frame) {
  Json json = {{"frame", frame.frame},
               {"box", frame.present ? Json::array({frame.x0, frame.y0, frame.x1, frame.y1}) : Json()},
               {"area", frame.area()},
               {"dark_ratio", frame.dark_ratio}};
  if (frame.behind > 0) json["behind"] = frame.behind;
  return json;
}

Json foregrounds_json(const std::vector<FrameForeground>& frames) {
  Json list = Json::array();
  for (const FrameForeground& frame : frames) list.push_back(foreground_json(frame));
  return list;
}

OwnFrame own_frame_from(const Json& json, const std::string& path) {
  OwnFrame own;
  for (const Json& turn : json.at("turns")) {
    own.turns.push_back(
        {turn.at("object").get<std::string>(), turn.at("degrees").get<double>(), turn.at("likeness").get<double>()});
  }
  own.turned_back = foreground_from(json.at("turned_back"), path, "/own_frame/turned_back");
  own.put_back = foreground_from(json.at("put_back"), path, "/own_frame/put_back");
  return own;
}

Json own_frame_json(const OwnFrame& own) {
  Json json;
  json["turns"] = Json::array();
  for (const OwnFrame::Turn& turn : own.turns)
    json["turns"].push_back({{"object", turn.object}, {"degrees", turn.degrees}, {"likeness", turn.likeness}});
  json["turned_back"] = foreground_json(own.turned_back);
  json["put_back"] = foreground_json(own.put_back);
  return json;
}

}  // namespace

std::optional<ForegroundRatios> foreground_ratios(const FrameForeground* first, const FrameForeground* last) {
  if (first == nullptr || last == nullptr || !first->present || !last->present) return std::nullopt;
  return ForegroundRatios{static_cast<double>(last->area()) / static_cast<double>(first->area()),
                          static_cast<double>(last->height()) / first->height(),
                          static_cast<double>(last->width()) / first->width()};
}

const FrameForeground* RenderRecord::endpoint(int t) const {
  for (const FrameForeground& frame : endpoints.empty() ? frames : endpoints) {
    if (frame.frame == t) return &frame;
  }
  return nullptr;
}

RenderRecord load_render(const std::string& path) {
  const Json document = load_record(path, "render");
  RenderRecord record;
  record.candidate = document.at("candidate").get<std::string>();
  if (!document.at("video").is_null()) record.video = document.at("video").get<std::string>();
  record.frames_written = document.at("frames_written").get<int>();
  record.file_size = document.at("file_size").get<long>();
  record.fps = document.value("fps", record.fps);
  record.width = document.at("width").get<int>();
  record.height = document.at("height").get<int>();
  record.frames = foregrounds_from(document.at("frames"), path, "/frames");
  if (document.contains("endpoints")) {
    record.endpoints = foregrounds_from(document.at("endpoints"), path, "/endpoints");
    if (record.endpoints[0].frame != 0)
      throw invalid_field(path, "/endpoints/0/frame", record.endpoints[0].frame, "0, the rest frame");
  }
  if (document.contains("own_frame")) record.own_frame = own_frame_from(document.at("own_frame"), path);
  record.skipped_gaussians = document.value("skipped_gaussians", 0L);
  record.depth_unit = document.value("depth_unit", 0.0);
  record.omitted = omissions_from(document);
  record.runtime = document.at("runtime");
  return record;
}

void save_render(const std::string& path, const RenderRecord& record, const Provenance& provenance) {
  Json json;
  json["candidate"] = record.candidate;
  json["video"] = record.video.empty() ? Json() : Json(record.video);
  json["frames_written"] = record.frames_written;
  json["file_size"] = record.file_size;
  json["fps"] = record.fps;
  json["width"] = record.width;
  json["height"] = record.height;
  json["frames"] = foregrounds_json(record.frames);
  if (!record.endpoints.empty()) json["endpoints"] = foregrounds_json(record.endpoints);
  if (record.own_frame) json["own_frame"] = own_frame_json(*record.own_frame);
  json["skipped_gaussians"] = record.skipped_gaussians;
  if (record.depth_unit > 0) json["depth_unit"] = record.depth_unit;
  json["omitted"] = to_json(record.omitted);
  json["runtime"] = record.runtime;
  save_record(path, "render", provenance, json);
}

}  // namespace physmas
