// What a tool tells make of its run, beside its artifacts: how long it took, or why it failed.
#ifndef PHYSMAS_BASE_STAGE_NOTES_H
#define PHYSMAS_BASE_STAGE_NOTES_H

#include <optional>
#include <string>

namespace physmas {

// Where the notes of a stage go, from the environment: PM_STAGE=STEM gives STEM.time and STEM.failed. Whoever starts a
// tool without it gets none. A note that cannot be written is none: it decides nothing.
void note_time(double seconds, long long peak_memory_bytes);
void note_failure(const std::string& tool, int code, const std::string& message);

struct StageTime {
  double seconds = 0;
  double peak_memory_bytes = 0;
};
struct StageFailure {
  std::string tool;
  int code = 0;         // exit code
  std::string message;  // one line
};
// Empty where there is none, or something else.
std::optional<StageTime> read_stage_time(const std::string& stem);
std::optional<StageFailure> read_stage_failure(const std::string& stem);

}  // namespace physmas

#endif
