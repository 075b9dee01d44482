#include "base/device.h"

#include "base/error.h"

namespace physmas {

Device choose_device(const std::string& name, int threads) {
  const Device device = {name == "cuda" ? Device::Kind::cuda : Device::Kind::cpu, threads, name == "auto"};
  require_device(device);
  return device;
}

void require_device(const Device& device) {
  if (device.kind != Device::Kind::cuda) return;
  const std::string absence = cuda_absence();
  if (!absence.empty()) throw Error(ExitCode::usage, "--device cuda: " + absence + ", expected cpu or auto");
}

}  // namespace physmas
