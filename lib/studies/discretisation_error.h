// The discretisation error of one run, estimated from the same scene on half and on a quarter of the cells.
#ifndef PHYSMAS_STUDIES_DISCRETISATION_ERROR_H
#define PHYSMAS_STUDIES_DISCRETISATION_ERROR_H

#include <string>
#include <vector>

#include "mpm/companion.h"
#include "records/camera.h"

namespace physmas::studies {

using mpm::Companion;
using mpm::make_companion;
using mpm::PointPaths;
using mpm::run_companion;

// Orders in dx that the estimate rests on. Contact is of first order, because surfaces are known to a cell only; where
// a stress cone lets material fall apart, the width of what slides is a cell, and half of an order is what is left
// (docs/numerics.md, "The error of your scene").
constexpr double kOrder = 1, kConeOrder = 0.5;
// Between these an observed order is regular.
constexpr double kLowestRegularOrder = 0.5, kHighestRegularOrder = 2.5;

// An error that was estimated from two differences: of the run and its companion of n/2, and of n/2 and n/4.
struct ErrorEstimate {
  double difference = 0, coarse_difference = 0;
  double estimate = 0;
  double bound = 0;  // twice the larger difference, or the estimate where that is more
  // log2 of the ratio of the differences; the lowest and the highest of the thirds of the run. 0 where there is none.
  double order = 0, lowest_order = 0, highest_order = 0;
  bool regular = false;
  std::string reason;  // why there is no estimate; else empty
};

// Points of a run at its output frames, in three resolutions.
struct RefinedPaths {
  PointPaths fine, half, quarter;  // [T][N] m, the same T and N
};

// Root mean square distance over points and frames [m], points of `row` only, -1: all. row_of: [N]; order: per row.
ErrorEstimate position_error(const RefinedPaths& paths, const std::vector<int>& row_of, int row,
                             const std::vector<double>& order);

// The paper's metrics of the image plane, of particles that are drawn as discs of `radius` [m].
struct ImageErrors {
  ErrorEstimate trajectory, area,
      strain;  // 100 times the raw RMSE (paper, Eqs. supp-traj, supp-area, supp-strain-error)
};
// camera: in the frame of the points. position: the estimate for all points, whose ratio to its difference is taken for
// these metrics, too.
ImageErrors image_errors(const RefinedPaths& paths, const Camera& camera, double radius, const ErrorEstimate& position);

// Order by row of a problem.
std::vector<double> orders_of(const mpm::Problem& problem);

// Longest edge of the bounding box of the points at rest [m], points of `row` only, -1: all; 0: no points.
double longest_edge(const std::vector<mpm::Vec3d>& rest, const std::vector<int>& row_of, int row);

}  // namespace physmas::studies

#endif
