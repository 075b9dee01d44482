// Notes of a stage: what was written is read, and what is none is nothing.
#include "base/stage_notes.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>

#include "base/file.h"
#include "unit/temporary_folder.h"

using namespace physmas;

TEST_CASE("stage notes: a time or a failure, never both, and none where nobody asks") {
  const TemporaryFolder folder;
  const std::string stem = folder.path() + "/lift";
  unsetenv("PM_STAGE");
  note_time(1, 2);
  CHECK_FALSE(read_stage_time(stem));
  setenv("PM_STAGE", stem.c_str(), 1);
  note_time(1.25, 3000);
  REQUIRE(read_stage_time(stem));
  CHECK(read_stage_time(stem)->seconds == 1.25);
  CHECK(read_stage_time(stem)->peak_memory_bytes == 3000);
  note_failure("pm-lift", 3, "a.json: found \"x\"\nsecond line");
  CHECK_FALSE(read_stage_time(stem));
  REQUIRE(read_stage_failure(stem));
  CHECK(read_stage_failure(stem)->tool == "pm-lift");
  CHECK(read_stage_failure(stem)->code == 3);
  CHECK(read_stage_failure(stem)->message.find("a.json: found \"x\"") == 0);
  CHECK(read_stage_failure(stem)->message.find('\n') == std::string::npos);
  note_time(2, 1);
  CHECK_FALSE(read_stage_failure(stem));
  for (const char* text : {"", "nan 1", "-1 5", "x", "1"}) {
    CAPTURE(text);
    write_file(stem + ".time", text);
    CHECK_FALSE(read_stage_time(stem));
  }
  setenv("PM_STAGE", (folder.path() + "/no/such/folder/lift").c_str(), 1);
  note_time(1, 1);  // decides nothing
  unsetenv("PM_STAGE");
}
