#include "splat/own_frame.h"

#include <algorithm>
#include <cmath>

#include "records/reference.h"
#include "splat/foreground.h"
#include "splat/polar.h"

namespace physmas::splat {
namespace {

bool finite_in_both(const TransportedFrame& first, const TransportedFrame& last, int32_t i) {
  return first.position(i).allFinite() && last.position(i).allFinite();
}

// The Gaussians of every object that has any, and its id.
struct Members {
  std::string object;
  std::vector<int32_t> gaussians;
};
std::vector<Members> objects_of(const State& state) {
  std::vector<Members> objects;
  for (size_t i = 0; i < state.gaussian_object.size(); ++i) {
    const size_t o = static_cast<size_t>(state.gaussian_object[i]);
    if (o >= objects.size()) objects.resize(o + 1);
    if (objects[o].gaussians.empty()) objects[o].object = object_of(state.row_keys.at(state.gaussian_row[i]));
    objects[o].gaussians.push_back(static_cast<int32_t>(i));
  }
  objects.erase(std::remove_if(objects.begin(), objects.end(), [](const Members& m) { return m.gaussians.empty(); }),
                objects.end());
  return objects;
}

Eigen::Vector3d mean_displacement(const TransportedFrame& first, const TransportedFrame& last, size_t n) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  long count = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!finite_in_both(first, last, static_cast<int32_t>(i))) continue;
    sum += (last.position(i) - first.position(i)).cast<double>();
    ++count;
  }
  return count > 0 ? Eigen::Vector3d(sum / static_cast<double>(count)) : sum;
}

}  // namespace

double RigidMotion::degrees() const {
  const double cosine = std::clamp((R.trace() - 1) / 2, -1.0, 1.0);
  return std::acos(cosine) * 180 / M_PI;
}

RigidMotion fit_rigid_motion(const TransportedFrame& first, const TransportedFrame& last,
                             const std::vector<int32_t>& members) {
  RigidMotion motion;
  long count = 0;
  for (const int32_t i : members) {
    if (!finite_in_both(first, last, i)) continue;
    motion.from += first.position(i).cast<double>();
    motion.to += last.position(i).cast<double>();
    ++count;
  }
  if (count == 0) return motion;
  motion.from /= static_cast<double>(count);
  motion.to /= static_cast<double>(count);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double rest = 0, moved = 0;
  for (const int32_t i : members) {
    if (!finite_in_both(first, last, i)) continue;
    const Eigen::Vector3d a = first.position(i).cast<double>() - motion.from;
    const Eigen::Vector3d b = last.position(i).cast<double>() - motion.to;
    covariance += b * a.transpose();
    rest += a.squaredNorm();
    moved += b.squaredNorm();
  }
  if (!(rest > 0) || !(moved > 0)) return motion;
  // Kabsch 1976: the rotation nearest to the covariance of the two point sets.
  motion.R = polar_rotation(covariance / std::sqrt(rest * moved));
  motion.likeness = std::clamp((motion.R.transpose() * covariance).trace() / std::sqrt(rest * moved), 0.0, 1.0);
  return motion;
}

std::optional<OwnFrame> measure_own_frame(Renderer& renderer, const Gaussians& gaussians, const RolloutFrames& rollout,
                                          const Scene& scene, const State& state, const RenderOptions& options,
                                          const RenderRecord& record) {
  const int t = scene.run.time.frames - 1;
  const auto image = foreground_ratios(record.endpoint(0), record.endpoint(t));
  if (!image || (!image->spread() && !image->flattened())) return std::nullopt;

  const TransportedFrame first = rollout.frame(0), last = rollout.frame(t);
  const std::vector<Members> objects = objects_of(state);
  const Eigen::Vector3d moved = mean_displacement(first, last, gaussians.size());
  const Camera& camera = scene.output_camera(0);
  const double near = options.near > 0 ? options.near : renderer.default_near();
  OwnFrame own;
  std::vector<RigidMotion> motions;
  for (const Members& object : objects) {
    motions.push_back(fit_rigid_motion(first, last, object.gaussians));
    own.turns.push_back({object.object, motions.back().degrees(), motions.back().likeness});
    if (motions.back().likeness < kLeastLikeness) motions.back().R.setIdentity();
  }
  // in_place: every object where it was, else where it is but for the motion of the whole.
  const auto measure = [&](bool in_place) {
    std::vector<Eigen::Vector3f> position(gaussians.size());
    std::vector<RowMatrix3f> F(gaussians.size());
    for (size_t o = 0; o < objects.size(); ++o) {
      const RigidMotion& motion = motions[o];
      const Eigen::Matrix3d back = motion.R.transpose();
      const Eigen::Vector3d center = in_place ? motion.from : Eigen::Vector3d(motion.to - moved);
      for (const int32_t i : objects[o].gaussians) {
        position[i] = (back * (last.position(i).cast<double>() - motion.to) + center).cast<float>();
        F[i] = (back * last.F(i).cast<double>()).cast<float>();
      }
    }
    const TransportedFrame frame(std::move(position), std::move(F));
    Window window = reach_of_splats(gaussians, frame, camera, near);
    if (too_large(window, around_picture(camera, 0)))
      window = intersection(window, around_picture(camera, kNearPictures));
    return measure_on_plane(renderer, frame, t, camera, window, options, scene.run.screening.dark_luminance);
  };
  own.put_back = measure(true);
  own.turned_back = objects.size() == 1 ? own.put_back : measure(false);
  return own;
}

}  // namespace physmas::splat
