// rollouts/ID.h5: the Gaussian particles of a simulated candidate at every output frame.
#ifndef PHYSMAS_RECORDS_ROLLOUT_H
#define PHYSMAS_RECORDS_ROLLOUT_H

#include <memory>
#include <string>
#include <vector>

#include "records/hdf5_file.h"

namespace physmas {

// Frames are written one by one; frame 0 is the rest frame. All values in solver space. N_G is the number of Gaussians
// that are particles (State::carrier_count).
class RolloutWriter {
 public:
  // deformation: what F is, "elastic" (after the return map) or "total".
  RolloutWriter(const std::string& path, uint64_t gaussian_count, const std::string& deformation,
                const Provenance& provenance);
  // position, velocity: [N_G, 3]; F: [N_G, 9], the deformation gradient by rows; time in seconds.
  void append(double time, const float* position, const float* F, const float* velocity);
  void commit();

 private:
  Hdf5Writer file_;
  std::vector<float> times_;
};

// One frame. F and velocity are [N_G, 9] and [N_G, 3].
struct RolloutFrame {
  std::vector<float> position, F, velocity;
};

class RolloutReader {
 public:
  // gaussian_count: the N_G that the rollout must have.
  RolloutReader(const std::string& path, uint64_t gaussian_count);
  int frame_count() const { return static_cast<int>(times_.size()); }
  double time(int frame) const { return times_[frame]; }
  // Values may be NaN in a diverged rollout; renderers skip such Gaussians.
  RolloutFrame frame(int t) const;

 private:
  Hdf5Reader file_;
  std::vector<float> times_;
};

}  // namespace physmas

#endif
