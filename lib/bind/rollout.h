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

// Writes the Gaussians, which are the first particles, of each frame that the solver hands out.
class RolloutRecorder {
 public:
  RolloutRecorder(const std::string& path, size_t gaussians, const mpm::Options& options, const Provenance& provenance);
  void append(const mpm::Frame& frame);
  void commit() { writer_.commit(); }

 private:
  size_t gaussians_;
  bool total_;
  RolloutWriter writer_;
  std::vector<float> position_, F_, velocity_;  // of one frame
};

}  // namespace physmas::bind

#endif
