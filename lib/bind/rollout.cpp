#include "bind/rollout.h"

namespace physmas::bind {
namespace {

mpm::Mat3d inverse(const mpm::Mat3d& A) {
  const mpm::Vec3d c = cross(A[1], A[2]);
  const mpm::Mat3d columns = {{c, cross(A[2], A[0]), cross(A[0], A[1])}};
  return (1 / dot(A[0], c)) * transpose(columns);
}

}  // namespace

std::string deformation_name(const mpm::Options& options) {
  return options.track_total_F ? "total" : "elastic";
}

RolloutRecorder::RolloutRecorder(const std::string& path, size_t gaussians, const mpm::Options& options,
                                 const Provenance& provenance)
    : gaussians_(gaussians),
      total_(options.track_total_F),
      writer_(path, gaussians, deformation_name(options), provenance),
      position_(3 * gaussians),
      F_(9 * gaussians),
      velocity_(3 * gaussians) {}

void RolloutRecorder::start_from(const std::vector<mpm::Mat3d>& F0) {
  inverse_F0_.clear();
  if (total_ || F0.empty()) return;  // the total deformation begins with the identity anyway
  for (size_t i = 0; i < gaussians_; ++i) inverse_F0_.push_back(inverse(F0[i]));
}

void RolloutRecorder::append(const mpm::Frame& frame) {
  const std::vector<mpm::Mat3d>& carrying = total_ ? frame.state.total_F : frame.state.F;
  for (size_t i = 0; i < gaussians_; ++i) {
    mpm::Mat3d F = carrying[i];
    if (!inverse_F0_.empty()) F = frame.index == 0 ? mpm::identity<double>() : F * inverse_F0_[i];
    for (int k = 0; k < 3; ++k) {
      position_[3 * i + k] = static_cast<float>(frame.state.x[i][k]);
      velocity_[3 * i + k] = static_cast<float>(frame.state.v[i][k]);
      for (int l = 0; l < 3; ++l) F_[9 * i + 3 * k + l] = static_cast<float>(F[k][l]);
    }
  }
  writer_.append(frame.time, position_.data(), F_.data(), velocity_.data());
}

}  // namespace physmas::bind
