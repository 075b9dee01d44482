// What an action says when it refuses its input.
#ifndef PHYSMAS_TESTS_INPUT_ERROR_H
#define PHYSMAS_TESTS_INPUT_ERROR_H

#include <doctest/doctest.h>

#include <functional>
#include <string>

#include "base/error.h"

namespace physmas {

// The message of the Error, which must have exit code 3; "no error" when there is none.
inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    CHECK(e.code() == ExitCode::invalid_input);
    return e.what();
  }
  return "no error";
}

}  // namespace physmas

#endif
