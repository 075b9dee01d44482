// Memory and threads that the machine does not give: how a tool says so and ends, whichever code notices.
#ifndef PHYSMAS_BASE_MACHINE_LIMITS_H
#define PHYSMAS_BASE_MACHINE_LIMITS_H

#include <exception>
#include <optional>

#include "base/error.h"

namespace physmas {

// Exit code 3: the machine is a place that lacks something.
Error out_of_memory();
Error no_thread();

// One of these where the exception means that memory or a thread was not to be had.
std::optional<Error> limit_behind(const std::exception& exception);

// Starts that many threads and ends them again. The runtime of OpenMP ends the process by itself where it gets none, so
// this is tried first. Error as above.
void require_threads(int threads);

// From here on an exception that nothing catches (one out of a parallel region), memory that runs out and a signal that
// a fault raises are reported in one line, remove half-written files and end with the exit code of what went wrong.
// True.
bool report_sudden_ends();

// While it lives, the exit of OpenMP's runtime, which lacks a thread or memory, ends in the same way. One at a time.
class ForeignExits {
 public:
  ForeignExits();
  ~ForeignExits();
  ForeignExits(const ForeignExits&) = delete;
  ForeignExits& operator=(const ForeignExits&) = delete;
};

}  // namespace physmas

#endif
