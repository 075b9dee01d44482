// What the command lines of all tools share: common options, the main wrapper, exit codes.
#ifndef PHYSMAS_BASE_COMMAND_LINE_H
#define PHYSMAS_BASE_COMMAND_LINE_H

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/device.h"

namespace physmas {

// Options that mean the same in every tool.
struct CommonOptions {
  int threads = 0;  // 0: all cores
  Device device;    // with as many threads
};

// A tool's command line. `options` fills the parser; `work` runs after parsing and returns the exit code.
// An Error becomes "TOOL: error: text" on stderr and its exit code; running out of memory and other exceptions
// become exit code 70. `--help` and `--version` print to stdout and exit 0, usage errors exit 2.
struct ToolMain {
  std::string name;         // "pm-lift"
  std::string description;  // one sentence: what goes in, what comes out
  std::string footer;       // an example call and the records it reads and writes
  std::function<void(CLI::App&)> options;
  std::function<int(const CommonOptions&)> work;
};

// A subcommand of a tool that has several.
struct Subcommand {
  CLI::App* app = nullptr;  // parsed(): this is what was asked for
  std::function<int(const CommonOptions&)> work;
};

int run_tool(int argc, char** argv, const ToolMain& tool);

}  // namespace physmas

#endif
