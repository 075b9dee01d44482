// Messages to the person at the terminal: all of them go to stderr, one line each, as "TOOL: LEVEL: text".
#ifndef PHYSMAS_BASE_LOG_H
#define PHYSMAS_BASE_LOG_H

#include <string>

namespace physmas {

enum class LogLevel { error = 0, warning = 1, info = 2, debug = 3 };

// Set once by the command line (`--quiet`, `--log-level`); errors are always shown.
void set_log_level(LogLevel level);
LogLevel log_level();

// The tool's name is the prefix of every line.
void set_tool_name(const std::string& name);
const std::string& tool_name();

void log_error(const std::string& text);
void log_warning(const std::string& text);
// For the user, without being asked, and no warning: what was assumed.
void log_note(const std::string& text);
void log_info(const std::string& text);
void log_debug(const std::string& text);

// One of several jobs of the same kind: candidate 2 of 6.
struct ProgressPart {
  long index = 1, count = 1;
  // From the environment variable PM_CANDIDATE, "2/6", as make sets it; the only one where it says nothing useful.
  static ProgressPart from_environment();
};

// "candidate 2 of 6, frame 12 of 50, about 40 s left in all". Those that follow are taken to last as long as this one.
// elapsed: seconds since this one began.
std::string progress_text(const ProgressPart& part, const std::string& label, long done, long total, double elapsed);

// A progress line with the time left, redrawn in place. Silent unless stderr is a terminal and the level is at least
// warning.
class Progress {
 public:
  // label: what is being counted ("frame"); total: how many there will be, > 0.
  Progress(std::string label, long total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // done: how many are finished, 0..total. Draws at most ten times a second.
  void update(long done);

 private:
  std::string label_;
  long total_;
  ProgressPart part_;
  double start_;
  double last_draw_ = -1;
  bool active_;
};

}  // namespace physmas

#endif
