#include "bind/rollout.h"

namespace physmas::bind {

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

void RolloutRecorder::append(const mpm::Frame& frame) {
  const std::vector<mpm::Mat3d>& F = total_ ? frame.state.total_F : frame.state.F;
  for (size_t i = 0; i < gaussians_; ++i) {
    for (int k = 0; k < 3; ++k) {
      position_[3 * i + k] = static_cast<float>(frame.state.x[i][k]);
      velocity_[3 * i + k] = static_cast<float>(frame.state.v[i][k]);
      for (int l = 0; l < 3; ++l) F_[9 * i + 3 * k + l] = static_cast<float>(F[i][k][l]);
    }
  }
  writer_.append(frame.time, position_.data(), F_.data(), velocity_.data());
}

}  // namespace physmas::bind
