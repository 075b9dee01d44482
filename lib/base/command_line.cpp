#include "base/command_line.h"

#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <optional>
#include <sstream>
#include <utility>

#include "base/clock.h"
#include "base/cuda_build.h"
#include "base/error.h"
#include "base/kernels.h"
#include "base/log.h"
#include "base/machine_limits.h"
#include "base/output.h"
#include "base/stage_notes.h"

namespace physmas {
namespace {

std::string version_text(const std::string& tool) {
  std::string features = name_of(widest_kernels());
#ifdef __SANITIZE_ADDRESS__
  features += " sanitizers";
#endif
  return fmt::format("{} {} (compiler {}; built with OpenMP, {}; {})", tool, PHYSMAS_VERSION, __VERSION__, features,
                     cuda_build());
}

// An option given twice takes its last value, so that a script can append to a command.
void last_value_wins(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    const bool undecided = option->get_multi_option_policy() == CLI::MultiOptionPolicy::Throw;
    if (undecided && option->get_expected_max() == 1) option->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) last_value_wins(*command);
}

}  // namespace

Option Option::required() const {
  return Option(option_->required());
}

Option Option::check(const std::function<std::string(const std::string&)>& refusal) const {
  return Option(option_->check(refusal));
}

template <class Number>
Option Option::between(Number low, Number high) const {
  return Option(option_->check(CLI::Range(low, high)));
}
template Option Option::between(int, int) const;
template Option Option::between(long long, long long) const;
template Option Option::between(double, double) const;

Option Option::not_negative() const {
  return Option(option_->check(CLI::NonNegativeNumber));
}

Option Option::one_of(const std::vector<std::string>& words) const {
  return Option(option_->check(CLI::IsMember(words)));
}

Option Option::needs(Option other) const {
  return Option(option_->needs(other.option_));
}

Option Option::needs(const std::string& flag) const {
  return Option(option_->needs(flag));
}

Option Option::excludes(Option other) const {
  return Option(option_->excludes(other.option_));
}

Option Option::expected(int values) const {
  return Option(option_->expected(values));
}

Option Option::take_all() const {
  return Option(option_->take_all());
}

Option Option::type_name(const std::string& name) const {
  return Option(option_->type_name(name));
}

Option Option::group(const std::string& title) const {
  return Option(option_->group(title));
}

Option Option::capture_default_str() const {
  return Option(option_->capture_default_str());
}

template <class Value>
Option Command::add_option(const std::string& flag, Value& value, const std::string& text) const {
  return Option(app_->add_option(flag, value, text));
}
template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, int&, const std::string&) const;
template Option Command::add_option(const std::string&, long&, const std::string&) const;
template Option Command::add_option(const std::string&, long long&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&) const;

Option Command::add_flag(const std::string& flag, bool& value, const std::string& text) const {
  return Option(app_->add_flag(flag, value, text));
}

Command Command::add_subcommand(const std::string& name, const std::string& text) const {
  return Command(app_->add_subcommand(name, text));
}

Command Command::add_option_group(const std::string& name, const std::string& text) const {
  return Command(app_->add_option_group(name, text));
}

Command Command::require_subcommand(int count) const {
  return Command(app_->require_subcommand(count));
}

Command Command::require_option(int count) const {
  return Command(app_->require_option(count));
}

Command Command::fallthrough() const {
  return Command(app_->fallthrough());
}

bool Command::parsed() const {
  return app_->parsed();
}

namespace {

// Before main(), whose first lines can run out of memory.
[[maybe_unused]] const bool kReported = report_sudden_ends();

// Exceptions are for the caller.
int parse_and_work(int argc, char** argv, const ToolMain& tool) {
  CommonOptions common;
  std::string level = "warning", device = "auto";
  bool quiet = false;
  CLI::App app(tool.description, tool.name);
  app.footer(tool.footer);
  app.get_formatter()->column_width(34);
  // Common options may stand after a subcommand, too.
  app.fallthrough();
  tool.options(Command(&app));
  app.add_option("--threads", common.threads, "Number of threads, 0 for all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str()
      ->group("Common");
  app.add_option("--device", device, "Where to compute: auto, cpu or cuda")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str()
      ->group("Common");
  app.add_option("--log-level", level, "error, warning, info or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}))
      ->capture_default_str()
      ->group("Common");
  app.add_flag("--quiet", quiet, "Print errors only")->group("Common");
  app.set_version_flag("--version", version_text(tool.name));
  last_value_wins(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    std::ostringstream text;
    const int code = app.exit(e, text, text);
    print_text(text.str());
    return code;
  } catch (const CLI::ParseError& e) {
    log_error(std::string(e.what()) + "; see " + tool.name + " --help");
    return static_cast<int>(ExitCode::usage);
  }
  const std::vector<std::pair<std::string, LogLevel>> levels = {
      {"error", LogLevel::error}, {"warning", LogLevel::warning}, {"info", LogLevel::info}, {"debug", LogLevel::debug}};
  for (const auto& [name, value] : levels) {
    if (level == name) set_log_level(value);
  }
  if (quiet) set_log_level(LogLevel::error);
  require_threads(common.threads > 0 ? common.threads : omp_get_max_threads());
  if (common.threads > 0) omp_set_num_threads(common.threads);
  if (device == "cuda" && !tool.on_gpu) {
    throw Error(ExitCode::usage, "--device cuda: " + tool.name + " computes on the CPU only, expected cpu or auto");
  }
  common.device = choose_device(device, common.threads);
  chosen_kernels();  // here, where an error is reported
  return tool.work(common);
}

int report(const std::string& tool, const Error& error) {
  log_error(error.what());
  note_failure(tool, static_cast<int>(error.code()), error.what());
  return static_cast<int>(error.code());
}

}  // namespace

int run_tool(int argc, char** argv, const ToolMain& tool) {
  set_tool_name(tool.name);
  // A write to a closed pipe, or beyond the limit of a file's size, must be an error that we report, not a silent
  // death.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const ForeignExits watched;
  const Stopwatch watch;
  try {
    const int code = parse_and_work(argc, argv, tool);
    note_time(watch.seconds(), peak_memory_bytes());
    return code;
  } catch (const Error& e) {
    return report(tool.name, e);
  } catch (const std::exception& e) {
    if (const std::optional<Error> limit = limit_behind(e)) return report(tool.name, *limit);
    return report(tool.name, internal_error(e.what()));
  }
}

}  // namespace physmas
