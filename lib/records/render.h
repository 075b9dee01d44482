// videos/ID.json: the render record of a candidate.
#ifndef PHYSMAS_RECORDS_RENDER_H
#define PHYSMAS_RECORDS_RENDER_H

#include <optional>
#include <string>
#include <vector>

#include "records/json.h"

namespace physmas {

// Limits of the spread and flattening gates (paper, "Validity Gate, Ranking, and Tie Rules"); two terms of the score
// have the same ones.
constexpr double kSpreadLimit = 2.0;  // foreground-box area, last over first
constexpr double kFlatHeight = 0.45, kFlatWidth = 1.25;

// Foreground of one rendered frame, from its alpha channel.
struct FrameForeground {
  int frame = 0;
  bool present = false;                // false: the frame is empty and the box means nothing
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels, x1 and y1 exclusive
  double dark_ratio = 0;               // share of foreground pixels below the dark luminance
  long behind = 0;                     // endpoints: Gaussians that went behind the camera, which the box takes in
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  long area() const { return present ? static_cast<long>(width()) * height() : 0; }
};

// How two foreground boxes compare, last over first.
struct ForegroundRatios {
  double area_growth = 0;  // box width x height
  double height_ratio = 0, width_ratio = 0;

  bool spread() const { return area_growth > kSpreadLimit; }
  bool flattened() const { return height_ratio < kFlatHeight && width_ratio > kFlatWidth; }
};

// Nothing when a frame is missing or empty.
std::optional<ForegroundRatios> foreground_ratios(const FrameForeground* first, const FrameForeground* last);

// The foreground of the last frame after the objects' own turns and moves are taken out of it, as boxes in the first
// output camera. `turned_back`: every object is turned back about its own centroid by the best-fit rotation of its
// Gaussians between the frames, and the scene as a whole is moved back to its place; what flew apart still is.
// `put_back`: every object is also moved back to where it was. The same where the scene has one object.
struct OwnFrame {
  struct Turn {
    std::string object;   // id
    double degrees = 0;   // angle of the best-fit rotation, 0..180
    double likeness = 0;  // 0..1: how well the turned rest shape fits; 1 for a rigid motion
  };
  std::vector<Turn> turns;  // objects that have Gaussians, in the inventory's order
  FrameForeground turned_back, put_back;
};

struct RenderRecord {
  std::string candidate;
  std::string video;  // file name beside the record, empty when none was written
  int frames_written = 0;
  long file_size = 0;  // bytes
  double fps = 25;
  int width = 0, height = 0;
  std::vector<FrameForeground> frames;  // what the video's pictures show
  // Frames 0 and T-1 in the first output camera, on an image plane that is not cut at the picture's edge: what the
  // screen compares. Empty where `frames` says the same.
  std::vector<FrameForeground> endpoints;
  std::optional<OwnFrame> own_frame;  // of frame T-1, where the image boxes would fail spread or flattening
  long skipped_gaussians = 0;
  double depth_unit = 0;  // scene units per level of the depth pictures; 0: none were written
  std::vector<Omission> omitted;
  Json runtime = Json::object();

  // Frame t as the screen sees it: of `endpoints`, or of `frames` where there are none. Null when it was not rendered.
  const FrameForeground* endpoint(int t) const;
};

RenderRecord load_render(const std::string& path);
void save_render(const std::string& path, const RenderRecord& record, const Provenance& provenance);

}  // namespace physmas

#endif
