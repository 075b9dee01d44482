#include "eval/video_tracks.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "base/error.h"
#include "eval/array_file.h"
#include "splat/video.h"

namespace physmas::eval {
namespace {

constexpr float kReturnDistance = 1;  // pixels

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

}  // namespace

Tracks load_tracks(const std::string& path, int width, int height) {
  const auto arrays = load_arrays(path, {"tracks", "visibility"});
  const Array &points = arrays.at("tracks"), &visibility = arrays.at("visibility");
  const std::vector<size_t> shape = without_batch(points, 3), seen = without_batch(visibility, 2);
  if (shape.size() != 3 || shape[2] != 2)
    throw invalid_input({path, "tracks", shape_text(points.shape), "[1, T, N, 2] or [T, N, 2]"});
  if (seen.size() != 2 || seen[0] != shape[0] || seen[1] != shape[1])
    throw invalid_input({path, "visibility", shape_text(visibility.shape),
                         fmt::format("[1, {0}, {1}] or [{0}, {1}] as the tracks", shape[0], shape[1])});
  Tracks tracks;
  tracks.width = width;
  tracks.height = height;
  for (size_t t = 0; t < shape[0]; ++t) {
    std::vector<Eigen::Vector2d> position;
    std::vector<uint8_t> visible;
    for (size_t i = 0; i < shape[1]; ++i) {
      const size_t k = t * shape[1] + i;
      const double v = visibility.values[k];
      if (!(v >= 0 && v <= 1))
        throw invalid_input(
            {path, fmt::format("visibility, frame {}, point {}", t, i), fmt::format("{}", v), "0 to 1"});
      position.emplace_back(points.values[2 * k] + 0.5, points.values[2 * k + 1] + 0.5);
      visible.push_back(v > 0.5 && position.back().allFinite() ? 1 : 0);
    }
    tracks.position.push_back(std::move(position));
    tracks.visible.push_back(std::move(visible));
  }
  return tracks;
}

Tracks track_by_flow(const std::string& video, const std::vector<QueryPixel>& queries) {
  Tracks tracks;
  std::vector<cv::Point2f> now;
  std::vector<uint8_t> alive(queries.size(), 1);
  for (const QueryPixel& q : queries) now.emplace_back(static_cast<float>(q.x), static_cast<float>(q.y));
  cv::Mat last;
  splat::decode_video(video, [&](const Image& frame) {
    const cv::Mat picture = grey(frame);
    if (last.empty()) {
      tracks.width = frame.width, tracks.height = frame.height;
    } else if (!now.empty()) {
      std::vector<cv::Point2f> next, back;
      std::vector<uint8_t> forward, backward;
      std::vector<float> error;
      cv::calcOpticalFlowPyrLK(last, picture, now, next, forward, error);
      cv::calcOpticalFlowPyrLK(picture, last, next, back, backward, error);
      for (size_t i = 0; i < now.size(); ++i) {
        const bool inside = next[i].x >= 0 && next[i].y >= 0 && next[i].x <= static_cast<float>(frame.width - 1) &&
                            next[i].y <= static_cast<float>(frame.height - 1);
        if (forward[i] == 0 || backward[i] == 0 || !inside || cv::norm(back[i] - now[i]) > kReturnDistance)
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

}  // namespace physmas::eval
