#include "base/stage_notes.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "base/file.h"

namespace physmas {
namespace {

constexpr size_t kMostNoteBytes = 1 << 16;

std::string stem_of_stage() {
  const char* stem = std::getenv("PM_STAGE");
  return stem != nullptr ? stem : "";
}

void write_note(const char* kind, const char* other, const std::string& text) {
  const std::string stem = stem_of_stage();
  if (stem.empty()) return;
  try {
    std::error_code ignored;
    std::filesystem::remove(stem + other, ignored);
    write_file(stem + kind, text);
  } catch (const std::exception&) {
  }
}

std::string text_of(const std::string& path) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure)) return "";
  try {
    return read_file(path, kMostNoteBytes);
  } catch (const std::exception&) {
    return "";
  }
}

}  // namespace

void note_time(double seconds, long long peak_memory_bytes) {
  write_note(".time", ".failed", fmt::format("{:.3f} {}\n", seconds, peak_memory_bytes));
}

void note_failure(const std::string& tool, int code, const std::string& message) {
  write_note(".failed", ".time", fmt::format("{} {}\n{}\n", tool, code, one_line(message, 4000)));
}

std::optional<StageTime> read_stage_time(const std::string& stem) {
  std::istringstream text(text_of(stem + ".time"));
  StageTime time;
  if (!(text >> time.seconds >> time.peak_memory_bytes)) return std::nullopt;
  if (!(time.seconds >= 0 && std::isfinite(time.seconds)) || !(time.peak_memory_bytes >= 0)) return std::nullopt;
  return time;
}

std::optional<StageFailure> read_stage_failure(const std::string& stem) {
  std::istringstream text(text_of(stem + ".failed"));
  StageFailure failure;
  if (!(text >> failure.tool >> failure.code)) return std::nullopt;
  std::getline(text, failure.message);
  std::getline(text, failure.message);
  return failure;
}

}  // namespace physmas
