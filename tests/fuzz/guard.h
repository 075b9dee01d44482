// What a reader may do with hostile input: return, or throw an Error that blames the input. Anything else is a fault.
#ifndef PHYSMAS_TESTS_FUZZ_GUARD_H
#define PHYSMAS_TESTS_FUZZ_GUARD_H

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "base/error.h"

// Both libFuzzer and driver.cpp call this.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace physmas {

template <class Action>
void guard(const Action& action) {
  std::string fault;
  try {
    action();
  } catch (const Error& error) {
    if (error.code() == ExitCode::internal) fault = error.what();
    if (std::string(error.what()).find('\n') != std::string::npos) fault = "a message of more than one line";
  } catch (const std::exception& exception) {
    fault = exception.what();
  }
  if (fault.empty()) return;
  std::fprintf(stderr, "fault: %s\n", fault.c_str());
  std::abort();
}

}  // namespace physmas

#endif
