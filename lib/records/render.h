// videos/ID.json: the render record of a candidate.
#ifndef PHYSMAS_RECORDS_RENDER_H
#define PHYSMAS_RECORDS_RENDER_H

#include <string>
#include <vector>

#include "records/json.h"

namespace physmas {

// Foreground of one rendered frame, from its alpha channel.
struct FrameForeground {
  int frame = 0;
  bool present = false;                // false: the frame is empty and the box means nothing
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels, x1 and y1 exclusive
  double dark_ratio = 0;               // share of foreground pixels below the dark luminance
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  long area() const { return present ? static_cast<long>(width()) * height() : 0; }
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
  long skipped_gaussians = 0;
  double depth_unit = 0;  // scene units per level of the depth pictures; 0: none were written
  std::vector<Omission> omitted;
  Json runtime = Json::object();
};

RenderRecord load_render(const std::string& path);
void save_render(const std::string& path, const RenderRecord& record, const Provenance& provenance);

}  // namespace physmas

#endif
