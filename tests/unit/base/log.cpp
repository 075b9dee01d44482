// What a progress line says.
#include "base/log.h"

#include <doctest/doctest.h>

#include <cstdlib>

using namespace physmas;

TEST_CASE("base: progress of one job, and of one among several, with the time that is left") {
  CHECK(progress_text({1, 1}, "frame", 0, 50, 0) == "frame 0 of 50");
  CHECK(progress_text({1, 1}, "frame", 12, 48, 10) == "frame 12 of 48, about 30 s left");
  // Four more candidates of 20 s each, and half of this one.
  CHECK(progress_text({2, 6}, "frame", 25, 50, 10) == "candidate 2 of 6, frame 25 of 50, about 90 s left in all");
  CHECK(progress_text({2, 6}, "frame", 25, 50, 60) == "candidate 2 of 6, frame 25 of 50, about 9 min left in all");
  CHECK(progress_text({6, 6}, "frame", 50, 50, 20) == "candidate 6 of 6, frame 50 of 50, about 0 s left in all");
}

TEST_CASE("base: which candidate it is comes from the environment, and nonsense there says nothing") {
  for (const char* text : {"", "6", "0/6", "7/6", "-1/-1", "a/b"}) {
    setenv("PM_CANDIDATE", text, 1);
    CHECK(ProgressPart::from_environment().count == 1);
  }
  setenv("PM_CANDIDATE", "2/6", 1);
  CHECK(ProgressPart::from_environment().index == 2);
  CHECK(ProgressPart::from_environment().count == 6);
  unsetenv("PM_CANDIDATE");
  CHECK(ProgressPart::from_environment().count == 1);
}
