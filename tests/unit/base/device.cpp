// Where a tool computes: what is not there is refused, not replaced.
#include "base/device.h"

#include <doctest/doctest.h>

#include "base/error.h"

using namespace physmas;

namespace {

// The exit code of the error that `call` throws, done when it throws none.
template <class Call>
ExitCode code_of(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.code();
  }
  return ExitCode::done;
}

}  // namespace

TEST_CASE("device: auto is the CPU with the threads asked for, cuda is refused where it was not built") {
  for (const char* name : {"auto", "cpu"}) {
    const Device device = choose_device(name, 3);
    CHECK(device.kind == Device::Kind::cpu);
    CHECK(device.threads == 3);
  }
  CHECK(code_of([] { choose_device("cuda", 0); }) == ExitCode::usage);
}
