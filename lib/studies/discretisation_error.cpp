#include "studies/discretisation_error.h"

#include <algorithm>
#include <cmath>

#include "metrics/motion.h"
#include "studies/point_tracks.h"

namespace physmas::studies {
namespace {

using mpm::Vec3d;

constexpr int kParts = 3;  // of a run, over which the observed order varies

double observed_order(double difference, double coarse_difference) {
  return difference > 0 && coarse_difference > 0 ? std::log2(coarse_difference / difference) : 0;
}

// What follows from the differences once they and the estimate are known.
void complete(ErrorEstimate& e) {
  e.bound = std::max(e.estimate, 2 * std::max(e.difference, e.coarse_difference));
  e.order = observed_order(e.difference, e.coarse_difference);
  e.regular = e.order >= kLowestRegularOrder && e.order <= kHighestRegularOrder;
}

// Sums of squares of one row's points in the frames [first, end).
double squares(const PointPaths& a, const PointPaths& b, const std::vector<int>& row_of, int row, size_t first,
               size_t end) {
  double sum = 0;
  for (size_t t = first; t < end; ++t) {
    for (size_t i = 0; i < row_of.size(); ++i) {
      if (row >= 0 && row_of[i] != row) continue;
      const Vec3d d = b[t][i] - a[t][i];
      sum += dot(d, d);
    }
  }
  return sum;
}

// The error of a run is the difference to its companion over 2^p - 1.
double extrapolated(double difference, double order) {
  return difference / (std::exp2(order) - 1);
}

metrics::TargetMotion track(const PointPaths& paths, const std::vector<int>& queries, PointTracker& tracker) {
  metrics::TargetMotion motion;
  for (const std::vector<Vec3d>& x : paths) tracker.add_frame(x, queries, motion);
  return motion;
}

// scale: estimate over difference.
ErrorEstimate image_error(const metrics::Measurement& near, const metrics::Measurement& far, double scale) {
  ErrorEstimate e;
  if (!near.valid || !far.valid) {
    e.reason = near.valid ? far.reason : near.reason;
    return e;
  }
  e.difference = near.value, e.coarse_difference = far.value;
  e.estimate = scale * e.difference;
  complete(e);
  return e;
}

}  // namespace

ErrorEstimate position_error(const RefinedPaths& paths, const std::vector<int>& row_of, int row,
                             const std::vector<double>& order) {
  ErrorEstimate e;
  const size_t frames = paths.fine.size();
  const auto points =
      static_cast<double>(std::count_if(row_of.begin(), row_of.end(), [&](int r) { return row < 0 || r == row; }));
  if (points == 0 || frames < 2) {
    e.reason = points == 0 ? "no points" : "no motion: one frame";
    return e;
  }
  const double samples = points * static_cast<double>(frames);
  double estimated = 0;
  for (int r = 0; r < static_cast<int>(order.size()); ++r) {
    if (row >= 0 && r != row) continue;
    const double factor = extrapolated(1, order[r]);
    estimated += factor * factor * squares(paths.fine, paths.half, row_of, r, 0, frames);
  }
  e.estimate = std::sqrt(estimated / samples);
  e.difference = std::sqrt(squares(paths.fine, paths.half, row_of, row, 0, frames) / samples);
  e.coarse_difference = std::sqrt(squares(paths.half, paths.quarter, row_of, row, 0, frames) / samples);
  complete(e);
  for (int k = 0; k < kParts; ++k) {
    // Frame 0 is the same in all.
    const size_t first = 1 + (frames - 1) * k / kParts, end = 1 + (frames - 1) * (k + 1) / kParts;
    if (first == end) continue;
    const double p = observed_order(std::sqrt(squares(paths.fine, paths.half, row_of, row, first, end)),
                                    std::sqrt(squares(paths.half, paths.quarter, row_of, row, first, end)));
    e.lowest_order = k == 0 ? p : std::min(e.lowest_order, p);
    e.highest_order = k == 0 ? p : std::max(e.highest_order, p);
  }
  return e;
}

ImageErrors image_errors(const RefinedPaths& paths, const Camera& camera, double radius,
                         const ErrorEstimate& position) {
  PointTracker tracker(camera, radius);
  const std::vector<int> queries = tracker.choose_queries(paths.fine.front());
  const metrics::TargetMotion fine = track(paths.fine, queries, tracker), half = track(paths.half, queries, tracker),
                              quarter = track(paths.quarter, queries, tracker);
  const double scale = position.difference > 0 ? position.estimate / position.difference : 1;
  return {image_error(metrics::trajectory_nrmse(fine.tracks, half.tracks),
                      metrics::trajectory_nrmse(half.tracks, quarter.tracks), scale),
          image_error(metrics::area_log_rmse(fine.areas, half.areas), metrics::area_log_rmse(half.areas, quarter.areas),
                      scale),
          image_error(metrics::strain_rmse(fine.tracks, half.tracks), metrics::strain_rmse(half.tracks, quarter.tracks),
                      scale)};
}

std::vector<double> orders_of(const mpm::Problem& problem) {
  std::vector<double> orders;
  for (const mpm::Material& m : problem.materials) {
    const bool falls_apart = m.branch == mpm::Branch::sand || m.branch == mpm::Branch::snow;
    orders.push_back(falls_apart ? kConeOrder : kOrder);
  }
  return orders;
}

double longest_edge(const std::vector<Vec3d>& rest, const std::vector<int>& row_of, int row) {
  double longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double low = 0, high = 0;
    bool any = false;
    for (size_t i = 0; i < row_of.size(); ++i) {
      if (row >= 0 && row_of[i] != row) continue;
      low = any ? std::min(low, rest[i][axis]) : rest[i][axis];
      high = any ? std::max(high, rest[i][axis]) : rest[i][axis];
      any = true;
    }
    longest = std::max(longest, high - low);
  }
  return longest;
}

}  // namespace physmas::studies
