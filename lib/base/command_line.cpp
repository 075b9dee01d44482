#include "base/command_line.h"

#include <fmt/format.h>
#include <omp.h>

#include <csignal>
#include <new>

#include "base/error.h"
#include "base/kernels.h"
#include "base/log.h"

namespace physmas {
namespace {

std::string version_text(const std::string& tool) {
  std::string features = name_of(widest_kernels());
#ifdef __SANITIZE_ADDRESS__
  features += " sanitizers";
#endif
  return fmt::format("{} {} (compiler {}; built with OpenMP, {}; without CUDA)", tool, PHYSMAS_VERSION, __VERSION__,
                     features);
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

int run_tool(int argc, char** argv, const ToolMain& tool) {
  set_tool_name(tool.name);
  // A write to a closed pipe must be an error that we report, not a silent death.
  std::signal(SIGPIPE, SIG_IGN);
  CommonOptions common;
  std::string level = "warning", device = "auto";
  bool quiet = false;
  CLI::App app(tool.description, tool.name);
  app.footer(tool.footer);
  app.get_formatter()->column_width(34);
  // Common options may stand after a subcommand, too.
  app.fallthrough();
  tool.options(app);
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
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    log_error(std::string(e.what()) + "; see " + tool.name + " --help");
    return static_cast<int>(ExitCode::usage);
  }
  try {
    const std::vector<std::pair<std::string, LogLevel>> levels = {{"error", LogLevel::error},
                                                                  {"warning", LogLevel::warning},
                                                                  {"info", LogLevel::info},
                                                                  {"debug", LogLevel::debug}};
    for (const auto& [name, value] : levels) {
      if (level == name) set_log_level(value);
    }
    if (quiet) set_log_level(LogLevel::error);
    if (common.threads > 0) omp_set_num_threads(common.threads);
    common.device = choose_device(device, common.threads);
    chosen_kernels();  // here, where an error is reported
    return tool.work(common);
  } catch (const Error& e) {
    log_error(e.what());
    return static_cast<int>(e.code());
  } catch (const std::bad_alloc&) {
    log_error("out of memory; use fewer particles, a smaller grid or smaller images");
    return static_cast<int>(ExitCode::internal);
  } catch (const std::exception& e) {
    log_error(std::string("internal fault: ") + e.what());
    return static_cast<int>(ExitCode::internal);
  }
}

}  // namespace physmas
