#include "splat/floor_shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "splat/middle_box.h"

namespace physmas::splat {
namespace {

using Eigen::Vector3d;

// All lengths are parts of the scene's size, the diagonal of its box.
constexpr int kLayers = 9;
constexpr double kSharpest = 0.011, kSofter = 1.6;  // standard deviation of the first layer; the next is so much softer
constexpr double kSoftening = 0.35;                 // standard deviation per height
constexpr double kDarkest = 0.36;                   // of a layer at the floor
constexpr double kFaintHeight = 0.5;                // at which it is half as dark
constexpr double kCellsPerDeviation = 1.25;         // of every layer
constexpr double kHalfSide = 1.6;                   // of the layers
constexpr double kBelow = 0.06;                     // what lies deeper under the floor throws no shadow
constexpr double kFadeFrom = 0.5, kFadeTo = 2.2;    // distance from the middle
constexpr float kTone = 0.75f, kToned = 0.25f;      // the floor is so much of the way from the background to this grey

double deviation_of(int layer) {
  return kSharpest * std::pow(kSofter, layer);
}

double darkness_of(int layer) {
  const double height = std::max(0.0, deviation_of(layer) - kSharpest) / kSoftening;
  return kDarkest / (1 + height / kFaintHeight);
}

int cells_of(int layer) {
  return std::max(8, static_cast<int>(std::ceil(2 * kHalfSide * kCellsPerDeviation / deviation_of(layer))));
}

float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

// Adds `mass` to the four cells around (u, v), which are in -1..1. touched: grows to hold every cell that has any.
void add_to(cv::Mat1f& layer, float u, float v, float mass, cv::Rect& touched) {
  const float x = (u + 1) * 0.5f * static_cast<float>(layer.cols) - 0.5f,
              y = (v + 1) * 0.5f * static_cast<float>(layer.rows) - 0.5f;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  if (i < 0 || j < 0 || i + 1 >= layer.cols || j + 1 >= layer.rows) return;
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  float* row = layer[j] + i;
  row[0] += mass * (1 - fx) * (1 - fy);
  row[1] += mass * fx * (1 - fy);
  row = layer[j + 1] + i;
  row[0] += mass * (1 - fx) * fy;
  row[1] += mass * fx * fy;
  if (!(touched.contains({i, j}) && touched.contains({i + 1, j + 1}))) touched |= cv::Rect(i, j, 2, 2);
}

// From the mass per cell to what is covered, as soft as a layer is.
void soften(cv::Mat1f& cells, const cv::Rect& touched) {
  if (touched.empty()) return;
  constexpr int kBetween = 2, kReach = static_cast<int>(3 * kCellsPerDeviation);
  const int room = kBetween + kReach;
  const cv::Rect around(touched.x - room, touched.y - room, touched.width + 2 * room, touched.height + 2 * room);
  // What is copied out is as if nothing were around it, which is so.
  cv::Mat1f part = cells(around & cv::Rect(0, 0, cells.cols, cells.rows)).clone();
  // What is between the spots belongs to them as well: their own width is about a cell.
  cv::GaussianBlur(part, part, {2 * kBetween + 1, 2 * kBetween + 1}, 0.9, 0.9, cv::BORDER_CONSTANT);
  for (int j = 0; j < part.rows; ++j) {
    for (float& cell : cv::Mat1f(part.row(j))) cell = cell > 0 ? 1 - std::exp(-cell) : 0;
  }
  cv::GaussianBlur(part, part, {2 * kReach + 1, 2 * kReach + 1}, kCellsPerDeviation, kCellsPerDeviation,
                   cv::BORDER_CONSTANT);
  part.copyTo(cells(around & cv::Rect(0, 0, cells.cols, cells.rows)));
}

// The value at (u, v), between the middles of cells; 1 outside.
float light_at(const cv::Mat1f& light, float u, float v) {
  const float x = (u + 1) * 0.5f * static_cast<float>(light.cols) - 0.5f,
              y = (v + 1) * 0.5f * static_cast<float>(light.rows) - 0.5f;
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(light.cols - 1) && y < static_cast<float>(light.rows - 1))) return 1;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const float *a = light[j] + i, *b = light[j + 1] + i;
  return (a[0] * (1 - fx) + a[1] * fx) * (1 - fy) + (b[0] * (1 - fx) + b[1] * fx) * fy;
}

}  // namespace

FloorPlane floor_plane(const RunSpecification& run, const SolverMap& map, const Gaussians& gaussians) {
  using Type = RunSpecification::Collider::Type;
  const Vector3d up = run.placement.up_vector();
  for (const RunSpecification::Collider& c : run.colliders) {
    if (c.type == Type::plane && c.normal.dot(up) > 0.5) return {map.to_scene(c.point), c.normal};
  }
  const double low = up.dot(map.to_solver(middle_box(gaussians).center()));
  const double wall = run.walls * run.grid.dx();
  double height = up.sum() > 0 ? wall : wall - run.grid.length;
  for (const RunSpecification::Collider& c : run.colliders) {
    const double top = std::max(up.dot(c.min), up.dot(c.max));
    if (c.type == Type::box && top < low) height = std::max(height, top);
  }
  const Vector3d middle = map.to_solver(middle_box(gaussians).center());
  return {map.to_scene(middle + (height - up.dot(middle)) * up), up};
}

FloorShadow::FloorShadow(const Gaussians& gaussians, const FloorPlane& plane, const Eigen::Vector3f& background)
    : gaussians_(gaussians), plane_(plane), background_(background) {
  const Eigen::AlignedBox3d box = middle_box(gaussians);
  // One Gaussian has a size as well.
  size_ = std::max(box.diagonal().norm(), 1e-6 * (1 + box.center().norm()));
  middle_ = box.center() - plane.normal.dot(box.center() - plane.point) * plane.normal;
  const Vector3d right = plane.normal.unitOrthogonal();
  to_plane_ << right.transpose(), plane.normal.cross(right).transpose(), plane.normal.transpose();
  to_plane_ /= size_;
  across_ = to_plane_.topRows<2>().cast<float>();
  const size_t n = gaussians.size();
  shape_.resize(n), opacity_.resize(n), spots_.resize(n);
#pragma omp parallel for
  for (size_t i = 0; i < n; ++i) {
    const RestShape rest = rest_shape(gaussians, i);
    shape_[i] = rest.M, opacity_[i] = rest.opacity;
  }
  for (int layer = 0; layer < kLayers; ++layer) layers_.emplace_back(cells_of(layer), cells_of(layer));
  light_ = cv::Mat1f(layers_[0].size(), 1.0f);
}

FloorShadow::Spot FloorShadow::spot_of(size_t i, const Eigen::Vector3f& position, const RowMatrix3f& F) const {
  const Spot none = {0, 0, -1, 0};
  // Double, because a scene may lie far from the origin.
  const Eigen::Vector3f at = (to_plane_ * (position.cast<double>() - middle_)).cast<float>();
  constexpr float kSide = static_cast<float>(kHalfSide);
  if (!(at.z() > -static_cast<float>(kBelow) && std::abs(at.x()) < kSide && std::abs(at.y()) < kSide)) return none;
  const Eigen::Matrix<float, 2, 3> across = across_ * F * shape_[i];
  const float square = 0.5f * across.squaredNorm();
  const float softness = static_cast<float>(kSharpest) + static_cast<float>(kSoftening) * std::max(0.0f, at.z());
  // In squares, so that one logarithm does.
  const float ratio = std::max(softness * softness, square) / static_cast<float>(kSharpest * kSharpest);
  const float layer = std::min(std::log2(ratio) / static_cast<float>(2 * std::log2(kSofter)), float{kLayers - 1});
  const float area =
      static_cast<float>(2 * EIGEN_PI) * std::max(across.row(0).cross(across.row(1)).norm(), 0.1f * square);
  if (!(area < 1e9f)) return none;  // neither infinite nor NaN
  return {at.x() / kSide, at.y() / kSide, layer, opacity_[i] * std::min(area, 1.0f)};
}

void FloorShadow::update(const Deformation& deformation) {
  const size_t n = gaussians_.size();
  const RowMatrix3f rest_F = RowMatrix3f::Identity();
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < n; ++i) {
    spots_[i] = spot_of(i, deformation.position ? deformation.position[i] : gaussians_.position[i],
                        deformation.F ? deformation.F[i] : rest_F);
  }
  for (cv::Mat1f& layer : layers_) layer = 0.0f;
    // In the order of the Gaussians, so that sums do not depend on threads.
#pragma omp parallel for schedule(dynamic, 1)
  for (int layer = 0; layer < kLayers; ++layer) {
    cv::Mat1f& cells = layers_[layer];
    const double side = 2 * kHalfSide / cells.cols;
    const float per_area = static_cast<float>(1 / (side * side));
    cv::Rect touched;
    for (const Spot& spot : spots_) {
      const float share = 1 - std::abs(spot.layer - static_cast<float>(layer));
      if (share > 0 && spot.layer >= 0) add_to(cells, spot.u, spot.v, share * spot.mass * per_area, touched);
    }
    soften(cells, touched);
  }
  cv::Mat1f light(layers_.back().size(), 1.0f);
  for (int layer = kLayers - 1; layer >= 0; --layer) {
    if (light.size() != layers_[layer].size()) cv::resize(light, light, layers_[layer].size(), 0, 0, cv::INTER_LINEAR);
    const float darkness = static_cast<float>(darkness_of(layer));
    for (int j = 0; j < light.rows; ++j) {
      float* const row = light[j];
      const float* const covered = layers_[layer][j];
      for (int i = 0; i < light.cols; ++i) row[i] *= 1 - darkness * covered[i];
    }
  }
  light_ = light;
}

cv::Mat FloorShadow::look_at_floor(const Camera& camera) const {
  // Half as fine as the picture: nothing on the floor is sharper than that.
  cv::Mat2f look((camera.height + 1) / 2, (camera.width + 1) / 2, cv::Vec2f(0, 0));
  const Eigen::Vector3f eye = (to_plane_ * (camera.center() - middle_)).cast<float>();
  if (eye.z() > 0) {
    const double dx = static_cast<double>(camera.width) / look.cols,
                 dy = static_cast<double>(camera.height) / look.rows;
    // Rays change evenly along a row of pixels.
    const Eigen::Matrix3d to_plane = to_plane_ * camera.rotation().transpose();
    const Eigen::Vector3f step = (to_plane.col(0) * (dx / camera.fx)).cast<float>();
    constexpr float kSide = static_cast<float>(kHalfSide), kTo = static_cast<float>(kFadeTo);
#pragma omp parallel for schedule(static)
    for (int j = 0; j < look.rows; ++j) {
      const Eigen::Vector3f first =
          (to_plane * Vector3d((0.5 * dx - camera.cx) / camera.fx, ((j + 0.5) * dy - camera.cy) / camera.fy, 1))
              .cast<float>();
      for (int i = 0; i < look.cols; ++i) {
        const Eigen::Vector3f ray = first + static_cast<float>(i) * step;
        const float far = eye.z() / -ray.z();
        const float u = eye.x() + far * ray.x(), v = eye.y() + far * ray.y(), away = u * u + v * v;
        if (!(ray.z() < 0 && away < kTo * kTo)) continue;
        const float edge = smooth_step(0.7f, 1, std::max(std::abs(u), std::abs(v)) / kSide);
        look(j, i) = {1 - smooth_step(static_cast<float>(kFadeFrom), kTo, std::sqrt(away)),
                      (1 - light_at(light_, u / kSide, v / kSide)) * (1 - edge)};
      }
    }
  }
  cv::Mat whole;
  cv::resize(look, whole, {camera.width, camera.height}, 0, 0, cv::INTER_LINEAR);
  return whole;
}

Image FloorShadow::picture(const RenderedImage& image, const Camera& camera) const {
  Image out(image.width, image.height, 3);
  const cv::Mat2f look = look_at_floor(camera);
  const Eigen::Vector3f tone = kToned * (Eigen::Vector3f::Constant(kTone) - background_);
  const float b[3] = {background_.x(), background_.y(), background_.z()}, t[3] = {tone.x(), tone.y(), tone.z()};
#pragma omp parallel for schedule(static)
  for (int y = 0; y < image.height; ++y) {
    const size_t row = static_cast<size_t>(y) * image.width;
    const cv::Vec2f* const floor = look[y];
    for (int x = 0; x < image.width; ++x) {
      const float through = 1 - image.alpha[row + x], seen = floor[x][0], light = 1 - floor[x][1];
      for (int k = 0; k < 3; ++k) {
        const float value = image.rgb[3 * (row + x) + k] + through * ((b[k] + seen * t[k]) * light - b[k]);
        out.pixels[3 * (row + x) + k] = static_cast<uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f);
      }
    }
  }
  return out;
}

}  // namespace physmas::splat
