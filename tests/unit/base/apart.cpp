// Work in a process of its own.
#include "base/apart.h"

#include <doctest/doctest.h>
#include <signal.h>

#include <cstdlib>

#include "base/error.h"
#include "unit/input_error.h"

using namespace physmas;

TEST_CASE("apart: work returns, refuses, crashes or takes too long, and nothing of it stays") {
  int seen = 1;
  CHECK(run_apart([&] { seen = 2; }, 10).done);
  CHECK(seen == 1);
  CHECK(message_of([] {
          run_apart([] { throw invalid_input({"f", "", "x", "y"}); }, 10);
        }) == "f: found x, expected y");
  CHECK_THROWS_AS(run_apart([] { throw std::bad_alloc(); }, 10), std::bad_alloc);
#ifndef __SANITIZE_ADDRESS__
  const Ending crash = run_apart([] { raise(SIGSEGV); }, 10);
  CHECK_FALSE(crash.done);
  CHECK(crash.signal == SIGSEGV);
#endif
  const Ending endless = run_apart(
      [] {
        for (volatile long i = 0;; i = i + 1) {
        }
      },
      1);
  CHECK_FALSE(endless.done);
  CHECK(endless.too_long);
}
