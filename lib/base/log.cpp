#include "base/log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "base/error.h"

namespace physmas {
namespace {

LogLevel g_level = LogLevel::warning;
std::string g_tool = "physmas";

// One write per line, so that lines of parallel jobs do not mix.
void print_line(const char* level, const std::string& text) {
  const std::string line = fmt::format("{}: {}{}\n", g_tool, level, one_line(text, 2000));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void set_log_level(LogLevel level) {
  g_level = level;
}
LogLevel log_level() {
  return g_level;
}
void set_tool_name(const std::string& name) {
  g_tool = name;
}
const std::string& tool_name() {
  return g_tool;
}

void log_error(const std::string& text) {
  print_line("error: ", text);
}
void log_warning(const std::string& text) {
  if (g_level >= LogLevel::warning) print_line("warning: ", text);
}
void log_note(const std::string& text) {
  if (g_level >= LogLevel::warning) print_line("note: ", text);
}
void log_info(const std::string& text) {
  if (g_level >= LogLevel::info) print_line("", text);
}
void log_debug(const std::string& text) {
  if (g_level >= LogLevel::debug) print_line("debug: ", text);
}

ProgressPart ProgressPart::from_environment() {
  ProgressPart part;
  const char* text = std::getenv("PM_CANDIDATE");
  if (text == nullptr || std::sscanf(text, "%ld/%ld", &part.index, &part.count) != 2 || part.index < 1 ||
      part.count < part.index) {
    return {};
  }
  return part;
}

std::string progress_text(const ProgressPart& part, const std::string& label, long done, long total, double elapsed) {
  std::string text;
  if (part.count > 1) text = fmt::format("candidate {} of {}, ", part.index, part.count);
  text += fmt::format("{} {} of {}", label, done, total);
  if (done == 0) return text;
  const double whole = elapsed * static_cast<double>(total) / static_cast<double>(done);
  const double left = whole - elapsed + whole * static_cast<double>(part.count - part.index);
  text += left < 100 ? fmt::format(", about {:.0f} s left", left) : fmt::format(", about {:.0f} min left", left / 60);
  return part.count > 1 ? text + " in all" : text;
}

Progress::Progress(std::string label, long total)
    : label_(std::move(label)),
      total_(total),
      part_(ProgressPart::from_environment()),
      start_(seconds_now()),
      active_(total > 0 && isatty(STDERR_FILENO) != 0 && g_level >= LogLevel::warning) {}

Progress::~Progress() {
  if (active_ && last_draw_ >= 0) std::fputs("\r\033[K", stderr);
}

void Progress::update(long done) {
  if (!active_) return;
  const double now = seconds_now();
  if (done < total_ && last_draw_ >= 0 && now - last_draw_ < 0.1) return;
  last_draw_ = now;
  std::fputs(fmt::format("\r{}: {} \033[K", g_tool, progress_text(part_, label_, done, total_, now - start_)).c_str(),
             stderr);
  std::fflush(stderr);
}

}  // namespace physmas
