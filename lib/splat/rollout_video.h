// A rollout's frames as a video and a render record, with whatever else is asked for beside them.
#ifndef PHYSMAS_SPLAT_ROLLOUT_VIDEO_H
#define PHYSMAS_SPLAT_ROLLOUT_VIDEO_H

#include <string>

#include "splat/frame_exports.h"

namespace physmas::splat {

struct RolloutVideoOptions {
  std::string scene, state, rollout;  // the scene or its render slice; the execution record lies beside the rollout
  std::string out;                    // .mp4; the record goes beside it
  std::string cameras;                // of fit_cameras; may be empty (video_cameras.h)
  std::string floor, candidate;       // video_pictures.h
  std::string frames;                 // only these, "0,10,20-24"; empty: all
  std::string png, depth;             // folders for a file per frame, or empty
  ExportOptions exports;              // Gaussians for other programs
  std::string sheet;                  // contact sheet .png, or empty
  std::string labels, inventory;      // video of the rows in colours, and the inventory that names them; or empty
};

// Renders and measures the frames of a rollout. One that ends early gets a record without a video; a video, sheet or
// video of rows of an earlier rollout is removed.
void render_rollout(const RolloutVideoOptions& options);

}  // namespace physmas::splat

#endif
