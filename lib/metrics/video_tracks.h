// Tracks of anyone's videos: from files as CoTracker3 users have them, by optical flow, or from a tracker on a
// model server.
#ifndef PHYSMAS_METRICS_VIDEO_TRACKS_H
#define PHYSMAS_METRICS_VIDEO_TRACKS_H

#include <map>
#include <string>
#include <vector>

#include "metrics/motion.h"
#include "metrics/query_grid.h"
#include "records/array_file.h"
#include "remote/inference.h"

namespace physmas::metrics {

// `tracks` [1, T, N, 2] or [T, N, 2], x and y in pixels with the first pixel's centre at 0, and `visibility` [1, T, N]
// or [T, N], visible above 0.5, from a .npz or JSON file. Here the first pixel's centre is at 0.5. A point that is not
// finite is not visible. width, height: of the tracked video, pixels.
Tracks load_tracks(const std::string& path, int width, int height);
// The same from arrays of these names; `file` is only named in messages.
Tracks tracks_from(const std::map<std::string, Array>& arrays, const std::string& file, int width, int height);

// Follows the queries through the video by pyramidal Lucas-Kanade flow (Bouguet 2001), frame to frame. A point is lost,
// and stays lost, when the flow fails, leaves the image, does not lead back to within one pixel, or leads to a patch
// that looks otherwise, as where something has come in front (more than 20 of 255 grey levels on average).
Tracks track_by_flow(const std::string& video, const std::vector<QueryPixel>& queries);

// Asks a tracker: `frames` BYTES [T], every element the base64 text of a PNG file, and `queries` FP32 [1, N, 3] (frame,
// x, y) to `tracks` [1, T, N, 2] and `visibility` [1, T, N], as load_tracks reads them. name: of the exchange. Without
// queries nothing is asked. Errors: exit code 4 when the reply does not fit.
Tracks track_by_server(remote::InferenceClient& tracker, const std::string& name, const std::string& video,
                       const std::vector<QueryPixel>& queries);

}  // namespace physmas::metrics

#endif
