// Which device a run is worth: what --device auto means to the solver.
#ifndef PHYSMAS_MPM_DEVICE_CHOICE_H
#define PHYSMAS_MPM_DEVICE_CHOICE_H

#include <string>

#include "mpm/simulation.h"

namespace physmas::mpm {

struct DeviceChoice {
  Device device;    // never automatic
  std::string why;  // a few words
};

// options.device where it was asked for, and else the GPU if there is one, it does what the options ask for, and the
// CPU would take so long that starting it pays. absence: why there is none, or empty (cuda_absence); asked only where
// the answer matters.
DeviceChoice choose_device(const Problem& problem, const Timing& timing, const Options& options,
                           const std::function<std::string()>& absence = cuda_absence);

}  // namespace physmas::mpm

#endif
