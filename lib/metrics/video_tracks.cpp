#include "metrics/video_tracks.h"

#include <fmt/format.h>

#include <functional>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "base/error.h"
#include "scene/image_file.h"
#include "splat/video.h"

namespace physmas::metrics {
namespace {

constexpr float kReturnDistance = 1;    // pixels
constexpr size_t kMaxFrames = 1 << 20;  // of tracks from files
constexpr float kPatchDifference = 20;  // grey levels of 255, mean over the patch of 21 x 21 pixels

// Without a leading batch axis of one.
std::vector<size_t> without_batch(const Array& array, size_t axes) {
  std::vector<size_t> shape = array.shape;
  if (shape.size() == axes + 1 && shape[0] == 1) shape.erase(shape.begin());
  return shape;
}

cv::Mat grey(const Image& frame) {
  const cv::Mat rgb(frame.height, frame.width, CV_8UC3, const_cast<uint8_t*>(frame.pixels.data()));
  cv::Mat out;
  cv::cvtColor(rgb, out, cv::COLOR_RGB2GRAY);
  return out;
}

// points: [T, N, 2], visibility: [T, N], as trackers write them. bad: makes the error of a field and what was found.
Tracks tracks_from(const std::vector<double>& points, const std::vector<double>& visibility, size_t frames,
                   size_t count, int width, int height,
                   const std::function<Error(const std::string&, const std::string&)>& bad) {
  Tracks tracks;
  tracks.width = width;
  tracks.height = height;
  for (size_t t = 0; t < frames; ++t) {
    std::vector<Eigen::Vector2d> position;
    std::vector<uint8_t> visible;
    for (size_t i = 0; i < count; ++i) {
      const size_t k = t * count + i;
      const double v = visibility[k];
      if (!(v >= 0 && v <= 1)) throw bad(fmt::format("visibility, frame {}, point {}", t, i), fmt::format("{}", v));
      position.emplace_back(points[2 * k] + 0.5, points[2 * k + 1] + 0.5);
      visible.push_back(v > 0.5 && position.back().allFinite() ? 1 : 0);
    }
    tracks.position.push_back(std::move(position));
    tracks.visible.push_back(std::move(visible));
  }
  return tracks;
}

}  // namespace

Tracks load_tracks(const std::string& path, int width, int height) {
  return tracks_from(load_arrays(path, {"tracks", "visibility"}), path, width, height);
}

Tracks tracks_from(const std::map<std::string, Array>& arrays, const std::string& file, int width, int height) {
  const Array &points = arrays.at("tracks"), &visibility = arrays.at("visibility");
  const std::vector<size_t> shape = without_batch(points, 3), seen = without_batch(visibility, 2);
  if (shape.size() != 3 || shape[2] != 2)
    throw invalid_input({file, "tracks", shape_text(points.shape), "[1, T, N, 2] or [T, N, 2]"});
  if (shape[0] > kMaxFrames)
    throw invalid_input({file, "tracks", shape_text(points.shape), fmt::format("at most {} frames", kMaxFrames)});
  if (seen.size() != 2 || seen[0] != shape[0] || seen[1] != shape[1])
    throw invalid_input({file, "visibility", shape_text(visibility.shape),
                         fmt::format("[1, {0}, {1}] or [{0}, {1}] as the tracks", shape[0], shape[1])});
  return tracks_from(points.values, visibility.values, shape[0], shape[1], width, height,
                     [&](const std::string& field, const std::string& found) {
                       return invalid_input({file, field, found, "0 to 1"});
                     });
}

Tracks track_by_flow(const std::string& video, const std::vector<QueryPixel>& queries) {
  Tracks tracks;
  std::vector<cv::Point2f> now;
  std::vector<uint8_t> alive(queries.size(), 1);
  for (const QueryPixel& q : queries) now.emplace_back(static_cast<float>(q.x), static_cast<float>(q.y));
  cv::Mat last;
  splat::decode_video(video, [&](const Image& frame) {
    const cv::Mat picture = grey(frame);
    if (!last.empty() && last.size() != picture.size())
      throw invalid_input({video, fmt::format("frame {}", tracks.frames()), "another size", "frames of one size"});
    if (last.empty()) {
      tracks.width = frame.width, tracks.height = frame.height;
    } else if (!now.empty()) {
      std::vector<cv::Point2f> next, back;
      std::vector<uint8_t> forward, backward;
      std::vector<float> difference, unused;
      cv::calcOpticalFlowPyrLK(last, picture, now, next, forward, difference);
      cv::calcOpticalFlowPyrLK(picture, last, next, back, backward, unused);
      for (size_t i = 0; i < now.size(); ++i) {
        const bool inside = next[i].x >= 0 && next[i].y >= 0 && next[i].x <= static_cast<float>(frame.width - 1) &&
                            next[i].y <= static_cast<float>(frame.height - 1);
        if (forward[i] == 0 || backward[i] == 0 || !inside || cv::norm(back[i] - now[i]) > kReturnDistance ||
            difference[i] > kPatchDifference)
          alive[i] = 0;
        if (alive[i] != 0) now[i] = next[i];
      }
    }
    picture.copyTo(last);
    std::vector<Eigen::Vector2d> position;
    for (const cv::Point2f& p : now) position.emplace_back(p.x + 0.5, p.y + 0.5);
    tracks.position.push_back(std::move(position));
    tracks.visible.push_back(alive);
  });
  return tracks;
}

Tracks track_by_server(remote::InferenceClient& tracker, const std::string& name, const std::string& video,
                       const std::vector<QueryPixel>& queries) {
  std::vector<std::string> pictures;
  const splat::VideoInfo info =
      splat::decode_video(video, [&](const Image& frame) { pictures.push_back(encode_png(frame)); });
  const size_t frames = pictures.size(), count = queries.size();
  const auto bad = [&](const std::string& field, const std::string& found) {
    return remote::provider_error(name, field + ": found " + found + ", expected 0 to 1");
  };
  if (count == 0) return tracks_from({}, {}, frames, 0, info.width, info.height, bad);
  const long T = static_cast<long>(frames), N = static_cast<long>(count);
  remote::InputTensor points{"queries", {1, N, 3}, {}, {}, {}};
  for (const QueryPixel& q : queries) {
    for (const int value : {0, q.x, q.y}) points.numbers.push_back(value);
  }
  const auto tensors = tracker.infer(name, {{"frames", {T}, pictures, {}, {}}, points},
                                     {{"tracks", {1, T, N, 2}}, {"visibility", {1, T, N}}});
  return tracks_from(tensors.at("tracks").numbers, tensors.at("visibility").numbers, frames, count, info.width,
                     info.height, bad);
}

}  // namespace physmas::metrics
