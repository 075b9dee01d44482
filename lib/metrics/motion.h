// Motion and deformation metrics against a paired reference (paper, "Reference-Video Motion and Deformation Metrics").
#ifndef PHYSMAS_METRICS_MOTION_H
#define PHYSMAS_METRICS_MOTION_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace physmas::metrics {

// Point tracks of one video: N points over T frames, pixels. A point that is not visible (or has left the target's
// mask, or is not finite) has visible = 0 and its position means nothing.
struct Tracks {
  int width = 0, height = 0;                           // pixels
  std::vector<std::vector<Eigen::Vector2d>> position;  // [T][N]
  std::vector<std::vector<uint8_t>> visible;           // [T][N]
  size_t frames() const { return position.size(); }
  size_t points() const { return position.empty() ? 0 : position.front().size(); }
};

// A measurement, or the reason why there is none: never a zero in its place.
struct Measurement {
  bool valid = false;
  double value = 0;    // 100 times the raw RMSE
  long samples = 0;    // point-frame pairs, or frames, that entered
  std::string reason;  // why it is not valid
};

// A frame counts only with at least this many jointly visible points.
constexpr int kMinimumPoints = 16;
// The frame-0 graph: neighbours per point, and how many of them must be jointly visible.
constexpr int kNeighbours = 8;
constexpr int kMinimumNeighbours = 4;
// Ridge of the local least squares, as a fraction of the mean eigenvalue, towards the identity; and the smallest ratio
// of eigenvalues that counts as nondegenerate (readings, "Metrics").
constexpr double kRidge = 1e-6;
constexpr double kDegenerate = 1e-6;

// Eq. (supp-traj): trajectory nRMSE over point-frame pairs that both videos show in that frame and in frame 0, over the
// frames with at least kMinimumPoints of them. Both tracks have the same frames, points and image size.
Measurement trajectory_nrmse(const Tracks& reference, const Tracks& predicted);

// Eq. (supp-area): projected-area log-RMSE. areas: visible target pixels per frame, [T]. A mask that becomes empty
// counts with area 0; one that is empty in frame 0 of either video is a target that was not found: invalid.
Measurement area_log_rmse(const std::vector<long>& reference, const std::vector<long>& predicted);

// Eqs. (supp-strain), (supp-strain-error): local Green-Lagrange strain RMSE over the reference's eight-neighbour graph
// of frame 0; rest offsets come from each video's own frame 0.
Measurement strain_rmse(const Tracks& reference, const Tracks& predicted);

}  // namespace physmas::metrics

#endif
