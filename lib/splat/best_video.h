// The video of a run in which nothing was accepted: its best candidate, with the reasons on the pictures.
#ifndef PHYSMAS_SPLAT_BEST_VIDEO_H
#define PHYSMAS_SPLAT_BEST_VIDEO_H

#include <string>
#include <vector>

#include "records/screen.h"

namespace physmas::splat {

struct BestVideoOptions {
  std::string scene, state, screen;  // the scene or its render slice, state.h5, and the last round's screen record
  std::string rollouts;              // folder with ID.h5 and ID.json
  std::string cameras;               // of fit_cameras; may be empty (video_cameras.h)
  std::string candidates;            // folder with ID.json, for render.agents: true; may be empty else
  std::string out;                   // .mp4
};

// What stands on the pictures: that it was not accepted, then a paragraph per failed gate with what to try.
std::vector<std::string> reasons_of(const ScreenedCandidate& candidate, const ScreenRecord& screen);

// Renders the candidate of the best rank that did not diverge or, when all did, the best of all: one that ends early
// stands still at its last frame. Returns its id. A record whose decision is not `fail` is an Error (exit code 3).
std::string write_best_video(const BestVideoOptions& options);

}  // namespace physmas::splat

#endif
