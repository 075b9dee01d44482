// The solver's output frames as a rollout.
#ifndef PHYSMAS_BIND_ROLLOUT_H
#define PHYSMAS_BIND_ROLLOUT_H

#include <string>
#include <vector>

#include "mpm/simulation.h"
#include "records/rollout.h"

namespace physmas::bind {

// What a rollout's F is, as its attribute and the execution record name it: "total" where the run tracks it, else
// "elastic".
std::string deformation_name(const mpm::Options& options);

// Writes the Gaussians among the particles, which are the first ones, of each frame that the solver hands out.
class RolloutRecorder {
 public:
  RolloutRecorder(const std::string& path, size_t gaussians, const mpm::Options& options, const Provenance& provenance);
  // F0: elastic F of all particles at the start, or empty: the identity. Gaussians show the captured shape in frame 0,
  // so what carries them is F F0⁻¹, the deformation since then.
  void start_from(const std::vector<mpm::Mat3d>& F0);
  void append(const mpm::Frame& frame);
  void commit() { writer_.commit(); }

 private:
  size_t gaussians_;
  bool total_;
  RolloutWriter writer_;
  std::vector<mpm::Mat3d> inverse_F0_;          // of the Gaussians, or empty
  std::vector<float> position_, F_, velocity_;  // of one frame
};

}  // namespace physmas::bind

#endif
