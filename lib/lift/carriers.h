// More Gaussians than particles: which of them are simulated, and how those carry the others.
#ifndef PHYSMAS_LIFT_CARRIERS_H
#define PHYSMAS_LIFT_CARRIERS_H

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "records/state.h"

namespace physmas::lift {

// The `count` Gaussians that stand for all, ascending. Every row is cut into cubes, as small as the count allows; of
// each cube the Gaussian nearest to the mean of those in it is taken, and what is then left of the count is taken from
// cubes of half the edge, evenly along a space-filling curve. So matter is found where the scene has it, however
// densely its Gaussians lie.
//
// means: [N] solver space. row: [N]. count: at least the number of rows with Gaussians, at most N. length: edge of the
// solver cube.
std::vector<int32_t> choose_carriers(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& row,
                                     size_t count, double length);

// Every other Gaussian follows its nearest carriers of the same row, at most kPerGaussian, with weights that fall with
// the squared distance. chosen: as choose_carriers gives them, at least one in every row with Gaussians.
Carriers carry(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& row,
               const std::vector<int32_t>& chosen);

}  // namespace physmas::lift

#endif
