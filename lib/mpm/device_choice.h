// Which device a run is worth: what --device auto means to the solver.
#ifndef PHYSMAS_MPM_DEVICE_CHOICE_H
#define PHYSMAS_MPM_DEVICE_CHOICE_H

#include <string>

#include "base/error.h"
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

// Returns work(device). Where a GPU that nobody asked for by name fails (its memory does not suffice, the driver gives
// up), once more for the CPU, which the choice then is; told(what went wrong) is called before.
template <class Work, class Told>
auto on_chosen_device(DeviceChoice& choice, bool automatic, const Work& work, const Told& told) {
  if (automatic && choice.device.kind == Device::Kind::cuda) {
    try {
      return work(choice.device);
    } catch (const Error& error) {
      choice.device.kind = Device::Kind::cpu;
      choice.why = std::string("the GPU failed: ") + error.what();
      told(error.what());
    }
  }
  return work(choice.device);
}

}  // namespace physmas::mpm

#endif
