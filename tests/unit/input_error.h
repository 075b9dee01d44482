// What an action says when it refuses its input.
#ifndef PHYSMAS_TESTS_INPUT_ERROR_H
#define PHYSMAS_TESTS_INPUT_ERROR_H

#include <doctest/doctest.h>

#include <functional>
#include <string>

#include "base/error.h"

namespace physmas {

// The message of the Error, which must have this exit code; "no error" when there is none.
inline std::string message_of(const std::function<void()>& action, ExitCode code = ExitCode::invalid_input) {
  try {
    action();
  } catch (const Error& e) {
    CHECK(e.code() == code);
    return e.what();
  }
  return "no error";
}

}  // namespace physmas

#endif
