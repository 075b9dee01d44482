#include "studies/point_tracks.h"

#include <algorithm>
#include <cmath>

namespace physmas::studies {

Camera study_camera() {
  return look_at({1.4, -0.95, 1.3}, {1, 1, 0.72}, {0, 0, 1}, 0.55, 400, 400);
}

void PointTracker::draw(const std::vector<mpm::Vec3d>& x) {
  const size_t pixels = static_cast<size_t>(camera_.width) * camera_.height;
  front_.assign(pixels, -1);
  depth_.assign(pixels, 0);
  for (size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector3d q = camera_.to_camera({x[i].x, x[i].y, x[i].z});
    if (!(q.z() > 0)) continue;
    const Eigen::Vector2d u = camera_.project(q);
    const double r = camera_.fx * radius_ / q.z();
    const auto first = [](double v) { return std::max(0, static_cast<int>(std::ceil(v - 0.5))); };
    const auto last = [](double v, int size) { return std::min(size - 1, static_cast<int>(std::floor(v - 0.5))); };
    if (!u.allFinite() || std::fabs(u.x()) > 1e6 || std::fabs(u.y()) > 1e6) continue;
    for (int py = first(u.y() - r); py <= last(u.y() + r, camera_.height); ++py) {
      const double dy = py + 0.5 - u.y();
      for (int px = first(u.x() - r); px <= last(u.x() + r, camera_.width); ++px) {
        const double dx = px + 0.5 - u.x();
        if (dx * dx + dy * dy > r * r) continue;
        const size_t p = static_cast<size_t>(py) * camera_.width + px;
        if (front_[p] >= 0 && depth_[p] <= q.z()) continue;
        front_[p] = static_cast<int>(i);
        depth_[p] = static_cast<float>(q.z());
      }
    }
  }
}

std::vector<int> PointTracker::choose_queries(const std::vector<mpm::Vec3d>& rest) {
  draw(rest);
  int low[2] = {camera_.width, camera_.height}, high[2] = {-1, -1};
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      if (front_[static_cast<size_t>(y) * camera_.width + x] < 0) continue;
      low[0] = std::min(low[0], x), high[0] = std::max(high[0], x);
      low[1] = std::min(low[1], y), high[1] = std::max(high[1], y);
    }
  }
  std::vector<int> queries;
  for (int j = 0; j < metrics::kGrid && high[0] >= 0; ++j) {
    for (int i = 0; i < metrics::kGrid; ++i) {
      const int x = low[0] + static_cast<int>((i + 0.5) * (high[0] + 1 - low[0]) / metrics::kGrid);
      const int y = low[1] + static_cast<int>((j + 0.5) * (high[1] + 1 - low[1]) / metrics::kGrid);
      const int particle = front_[static_cast<size_t>(y) * camera_.width + x];
      if (particle >= 0 && std::find(queries.begin(), queries.end(), particle) == queries.end())
        queries.push_back(particle);
    }
  }
  return queries;
}

void PointTracker::add_frame(const std::vector<mpm::Vec3d>& x, const std::vector<int>& queries,
                             metrics::TargetMotion& motion) {
  draw(x);
  motion.tracks.width = camera_.width;
  motion.tracks.height = camera_.height;
  motion.areas.push_back(static_cast<long>(std::count_if(front_.begin(), front_.end(), [](int p) { return p >= 0; })));
  std::vector<Eigen::Vector2d> position;
  std::vector<uint8_t> visible;
  for (const int i : queries) {
    const Eigen::Vector3d q = camera_.to_camera({x[i].x, x[i].y, x[i].z});
    const Eigen::Vector2d u = q.z() > 0 ? camera_.project(q) : Eigen::Vector2d(-1, -1);
    const bool inside = u.x() >= 0 && u.y() >= 0 && u.x() < camera_.width && u.y() < camera_.height;
    position.push_back(u);
    visible.push_back(
        inside && front_[static_cast<size_t>(u.y()) * camera_.width + static_cast<size_t>(u.x())] >= 0 ? 1 : 0);
  }
  motion.tracks.position.push_back(std::move(position));
  motion.tracks.visible.push_back(std::move(visible));
}

}  // namespace physmas::studies
