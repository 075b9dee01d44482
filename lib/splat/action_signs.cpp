#include "splat/action_signs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "base/constants.h"
#include "splat/middle_box.h"

namespace physmas::splat {
namespace {

using Eigen::Vector3d;
using Kind = ScheduleOperation::Kind;

// Parts of the scene's size.
constexpr double kLength = 0.2, kWidth = 0.03, kGap = 0.02;
constexpr double kNearest = 1e-3;  // depth of what is drawn
// RGB; one colour for what acts, one for what holds.
const cv::Scalar kActs(238, 122, 36), kHolds(44, 110, 190), kRim(70, 45, 30);
constexpr int kShift = 4;  // fractional bits of OpenCV's coordinates

// The box of some Gaussians along three axes of its own.
struct OwnBox {
  Eigen::Matrix3d axes;  // columns; the first is the direction of the action
  Vector3d center, half;
  Vector3d at(double x, double y, double z) const {
    return center + axes * Vector3d(x * half.x(), y * half.y(), z * half.z());
  }
  // The point `beyond` past the face of axis 0 at that side (1 or -1).
  Vector3d past(int side, double beyond) const { return center + side * (half.x() + beyond) * axes.col(0); }
};

std::optional<OwnBox> box_along(const Vector3d& direction, const TransportedFrame& frame,
                                const std::vector<size_t>& gaussians) {
  OwnBox box;
  const Vector3d across = direction.unitOrthogonal();
  box.axes << direction, across, direction.cross(across);
  std::vector<double> values;
  Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const size_t i : gaussians) {
      const double x = box.axes.col(axis).dot(frame.position(i).cast<double>());
      if (std::isfinite(x)) values.push_back(x);
    }
    if (values.empty()) return std::nullopt;
    const auto quantile = [&](double part) {
      const auto nth = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), nth, values.end());
      return *nth;
    };
    const double low = quantile(0.02), high = quantile(0.98);
    middle[axis] = 0.5 * (low + high);
    box.half[axis] = 0.5 * (high - low);
  }
  box.center = box.axes * middle;
  return box;
}

class Canvas {
 public:
  Canvas(Image& picture, const Camera& camera, double size)
      : pixels_(picture.height, picture.width, CV_8UC3, picture.pixels.data()), camera_(camera), size_(size) {}

  void arrow(const Vector3d& tail, const Vector3d& head, const cv::Scalar& color) {
    const auto a = project(tail), b = project(head);
    if (!a || !b) return;
    const Eigen::Vector2d along = *b - *a;
    // One that points at the camera or away from it is a dot.
    const double length = along.norm(), width = pixels(kWidth, 0.5 * (tail + head));
    if (length < 1.5 * width) {
      ring(0.5 * (*a + *b), width, color);
      return;
    }
    const Eigen::Vector2d d = along / length, n(-d.y(), d.x());
    const Eigen::Vector2d neck = *b - std::min(2.4 * width, 0.6 * length) * d;
    fill({*a + 0.45 * width * n, neck + 0.45 * width * n, neck + 1.3 * width * n, *b, neck - 1.3 * width * n,
          neck - 0.45 * width * n, *a - 0.45 * width * n},
         color, 0.9);
  }

  // Around the axis by the right-hand rule, on the side of the camera: a bent arrow of even width in the picture.
  void turn(const Vector3d& center, const Vector3d& axis, double radius, const cv::Scalar& color) {
    constexpr int kPieces = 40;
    constexpr double kAngle = 1.2 * kPi;
    const Vector3d view = camera_.center() - center, across = view - axis.dot(view) * axis;
    const Vector3d front = across.norm() > 1e-6 * view.norm() ? across.normalized() : axis.unitOrthogonal();
    const Vector3d side = axis.cross(front);
    std::vector<Eigen::Vector2d> line;
    for (int i = 0; i <= kPieces; ++i) {
      const double angle = kAngle * (static_cast<double>(i) / kPieces - 0.5);
      const auto p = project(center + radius * (std::cos(angle) * front + std::sin(angle) * side));
      if (!p) return;
      line.push_back(*p);
    }
    const double width = pixels(kWidth, center + radius * front);
    // The head takes the last pieces of the line, which its length is about that of.
    size_t neck = line.size() - 2;
    while (neck > 1 && (line.back() - line[neck]).norm() < 2.4 * width) --neck;
    std::vector<Eigen::Vector2d> outline, back;
    Eigen::Vector2d normal(0, 0);
    for (size_t i = 0; i <= neck; ++i) {
      const Eigen::Vector2d along = line[i + 1] - line[i];
      if (along.norm() > 1e-9) normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
      outline.push_back(line[i] + 0.45 * width * normal);
      back.push_back(line[i] - 0.45 * width * normal);
    }
    const Eigen::Vector2d head = line.back() - line[neck];
    if (head.norm() > 1e-9) normal = Eigen::Vector2d(-head.y(), head.x()).normalized();
    outline.insert(outline.end(), {line[neck] + 1.3 * width * normal, line.back(), line[neck] - 1.3 * width * normal});
    outline.insert(outline.end(), back.rbegin(), back.rend());
    fill(outline, color, 0.9);
  }

  void disc(const Vector3d& center, const Vector3d& u, const Vector3d& v, const cv::Scalar& color) {
    std::vector<Eigen::Vector2d> outline;
    for (int i = 0; i < 48; ++i) {
      const auto p = project(center + std::cos(kPi * i / 24) * u + std::sin(kPi * i / 24) * v);
      if (!p) return;
      outline.push_back(*p);
    }
    fill(outline, color, 0.5);
  }

  void pin(const Vector3d& at, const cv::Scalar& color) {
    if (const auto p = project(at)) ring(*p, 0.6 * pixels(kWidth, at), color);
  }

 private:
  std::optional<Eigen::Vector2d> project(const Vector3d& p) const {
    const Vector3d q = camera_.to_camera(p);
    if (!(q.z() > kNearest * size_)) return std::nullopt;
    const Eigen::Vector2d pixel = camera_.project(q);
    // OpenCV counts in 32 bits.
    if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) return std::nullopt;
    return pixel;
  }
  double pixels(double part, const Vector3d& at) const {
    const double depth = std::max(camera_.to_camera(at).z(), kNearest * size_);
    return std::clamp(part * size_ * camera_.fx / depth, 2.0, 60.0);
  }
  static cv::Point point(const Eigen::Vector2d& p) {
    // The centre of pixel i is at i + 0.5.
    return {static_cast<int>(std::lround((p.x() - 0.5) * (1 << kShift))),
            static_cast<int>(std::lround((p.y() - 0.5) * (1 << kShift)))};
  }
  void fill(const std::vector<Eigen::Vector2d>& outline, const cv::Scalar& color, double opacity) {
    std::vector<std::vector<cv::Point>> polygon(1);
    for (const Eigen::Vector2d& p : outline) polygon[0].push_back(point(p));
    cv::Mat over = pixels_.clone();
    cv::fillPoly(over, polygon, color, cv::LINE_AA, kShift);
    cv::polylines(over, polygon, true, kRim, std::max(1, pixels_.rows / 400), cv::LINE_AA, kShift);
    cv::addWeighted(over, opacity, pixels_, 1 - opacity, 0, pixels_);
  }
  void ring(const Eigen::Vector2d& at, double radius, const cv::Scalar& color) {
    const auto circle = [&](double r, const cv::Scalar& c) {
      cv::circle(pixels_, point(at), static_cast<int>(r * (1 << kShift)), c, cv::FILLED, cv::LINE_AA, kShift);
    };
    circle(radius + std::max(1.0, pixels_.rows / 400.0), kRim);
    circle(radius, color);
    circle(0.4 * radius, cv::Scalar(255, 255, 255));
  }

  cv::Mat pixels_;
  const Camera& camera_;
  double size_;
};

// Where the action is directed; a unit vector.
Vector3d direction_of(const ScheduleOperation& op, const Vector3d& up) {
  Vector3d direction = op.direction;
  if (op.kind == Kind::radial_spread) direction = up;
  if (op.kind == Kind::vertical_compress) direction = -up;
  const bool moves = op.kind == Kind::translation || op.kind == Kind::top_press || op.kind == Kind::impulse ||
                     op.kind == Kind::drag_pair;
  if (moves) direction = op.velocity;
  return direction.norm() > 1e-9 ? Vector3d(direction.normalized()) : Vector3d(-up);
}

// What a plan asks of several rows is compiled to an operation for each, with magnitudes of their own.
bool is_one_action(const ScheduleOperation& a, const ScheduleOperation& b, const Vector3d& up) {
  return a.kind == b.kind && a.start == b.start && a.end == b.end && a.slab_fraction == b.slab_fraction &&
         (a.rate < 0) == (b.rate < 0) && (a.ratio > 1) == (b.ratio > 1) &&
         direction_of(a, up).isApprox(direction_of(b, up), 1e-6);
}

void draw_sign(Canvas& canvas, const ScheduleOperation& op, const OwnBox& box, double size) {
  const double gap = kGap * size, length = kLength * size;
  const Vector3d d = box.axes.col(0);
  const auto press = [&] {
    const Vector3d at = box.past(-1, 0);
    canvas.disc(at, 0.85 * box.half.y() * box.axes.col(1), 0.85 * box.half.z() * box.axes.col(2), kActs);
    canvas.arrow(at - (gap + length) * d, at - gap * d, kActs);
  };
  switch (op.kind) {
    case Kind::translation:
    case Kind::impulse:
      canvas.arrow(box.past(-1, gap + length), box.past(-1, gap), kActs);
      break;
    case Kind::drag_pair:
      canvas.arrow(box.past(1, gap), box.past(1, gap + length), kActs);
      break;
    case Kind::top_press:
    case Kind::vertical_compress:
    case Kind::side_compress:
      press();
      break;
    case Kind::scale:
      for (const int side : {1, -1}) {
        const Vector3d near = box.past(side, gap), far = box.past(side, gap + length);
        canvas.arrow(op.ratio > 1 ? near : far, op.ratio > 1 ? far : near, kActs);
      }
      break;
    case Kind::radial_spread:
      for (int i = 0; i < 4; ++i) {
        const Vector3d out = (i % 2 == 0 ? 1 : -1) * box.axes.col(i < 2 ? 1 : 2);
        const Vector3d edge = box.center + (gap + (i < 2 ? box.half.y() : box.half.z())) * out;
        canvas.arrow(edge, edge + 0.6 * length * out, kActs);
      }
      break;
    case Kind::torque: {
      const Vector3d axis = (op.rate < 0 ? -1 : 1) * d;
      const double radius = std::max(std::hypot(box.half.y(), box.half.z()) * 0.8 + gap, 0.25 * length);
      canvas.turn(box.at(1 - op.slab_fraction, 0, 0), axis, radius, kActs);
      break;
    }
    case Kind::support_hold:
      for (int i = 0; i < 3; ++i) {
        const double angle = kPi * (0.5 + 2.0 * i / 3);
        canvas.pin(box.at(1 - op.slab_fraction, 0.6 * std::cos(angle), 0.6 * std::sin(angle)), kHolds);
      }
      break;
    case Kind::structure_projection:
    case Kind::interface_retention:
      break;
  }
}

}  // namespace

ActionSigns::ActionSigns(const Candidate& candidate, const State& state, const Gaussians& gaussians, const Vector3d& up)
    : up_(up), size_(std::max(middle_box(gaussians).diagonal().norm(), 1e-9)) {
  for (const ScheduleOperation& op : candidate.schedule) {
    if (!op.is_action()) continue;
    const auto same = std::find_if(acting_.begin(), acting_.end(),
                                   [&](const Acting& other) { return is_one_action(other.operation, op, up); });
    if (same == acting_.end()) {
      acting_.push_back({op, {}});
    } else {
      same->operation.rows.insert(same->operation.rows.end(), op.rows.begin(), op.rows.end());
    }
  }
  for (Acting& acting : acting_) {
    const std::vector<int>& rows = acting.operation.rows;
    for (size_t i = 0; i < state.gaussian_row.size(); ++i) {
      if (std::find(rows.begin(), rows.end(), state.gaussian_row[i]) != rows.end()) acting.gaussians.push_back(i);
    }
  }
}

void ActionSigns::draw(const TransportedFrame& frame, double time, const Camera& camera, Image& picture) const {
  Canvas canvas(picture, camera, size_);
  for (const Acting& acting : acting_) {
    const ScheduleOperation& op = acting.operation;
    // Frame times are rounded to float.
    if (time < op.start - 1e-6 || time >= std::max(op.end, op.start + kShortestSign) - 1e-6) continue;
    const std::optional<OwnBox> box = box_along(direction_of(op, up_), frame, acting.gaussians);
    if (box) draw_sign(canvas, op, *box, size_);
  }
}

}  // namespace physmas::splat
