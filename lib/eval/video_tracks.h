// Tracks of anyone's videos: from files as CoTracker3 users have them, or by optical flow.
#ifndef PHYSMAS_EVAL_VIDEO_TRACKS_H
#define PHYSMAS_EVAL_VIDEO_TRACKS_H

#include <string>
#include <vector>

#include "eval/motion.h"
#include "eval/query_grid.h"

namespace physmas::eval {

// `tracks` [1, T, N, 2] or [T, N, 2], x and y in pixels with the first pixel's centre at 0, and `visibility` [1, T, N]
// or [T, N], visible above 0.5, from a .npz or JSON file. Here the first pixel's centre is at 0.5. A point that is not
// finite is not visible. width, height: of the tracked video, pixels.
Tracks load_tracks(const std::string& path, int width, int height);

// Follows the queries through the video by pyramidal Lucas-Kanade flow (Bouguet 2001), frame to frame. A point is lost,
// and stays lost, when the flow fails, leaves the image, or does not lead back to within one pixel.
Tracks track_by_flow(const std::string& video, const std::vector<QueryPixel>& queries);

}  // namespace physmas::eval

#endif
