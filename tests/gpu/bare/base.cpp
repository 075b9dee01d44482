// What the solver needs of lib/base/machine_limits.cpp, without how a tool ends.
#include "base/machine_limits.h"

namespace physmas {

Error out_of_memory() {
  return Error(ExitCode::invalid_input, "the machine has no more memory");
}

Error no_thread() {
  return Error(ExitCode::invalid_input, "the machine gives no more threads");
}

}  // namespace physmas
