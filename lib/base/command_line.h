// What the command lines of all tools share: common options, the main wrapper, exit codes.
#ifndef PHYSMAS_BASE_COMMAND_LINE_H
#define PHYSMAS_BASE_COMMAND_LINE_H

#include <functional>
#include <string>
#include <vector>

#include "base/device.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace physmas {

// An option of a command line; a handle, copied freely. Only command_line.cpp sees the parser, which is slow to
// compile.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required() const;
  // The refusal, or nothing when the text is good.
  Option check(const std::function<std::string(const std::string&)>& refusal) const;
  template <class Number>  // int, long long or double
  Option between(Number low, Number high) const;
  Option not_negative() const;
  Option one_of(const std::vector<std::string>& words) const;
  Option needs(Option other) const;
  Option needs(const std::string& flag) const;
  Option excludes(Option other) const;
  Option expected(int values) const;
  Option take_all() const;  // given several times, it keeps all values; else the last one wins
  // What --help shows.
  Option type_name(const std::string& name) const;
  Option group(const std::string& title) const;
  Option capture_default_str() const;

 private:
  CLI::Option* option_;
};

// A command line, a subcommand or a group of options; a handle as well. What an option is read into must outlive
// parsing.
class Command {
 public:
  explicit Command(CLI::App* app = nullptr) : app_(app) {}
  template <class Value>  // std::string, int, long, long long, double, or a vector of strings or doubles
  Option add_option(const std::string& flag, Value& value, const std::string& text) const;
  Option add_flag(const std::string& flag, bool& value, const std::string& text) const;
  Command add_subcommand(const std::string& name, const std::string& text) const;
  Command add_option_group(const std::string& name, const std::string& text) const;
  Command require_subcommand(int count) const;
  Command require_option(int count) const;
  Command fallthrough() const;  // the options of this command may stand after a subcommand
  bool parsed() const;          // a subcommand: it is what was asked for

 private:
  CLI::App* app_;
};

// Options that mean the same in every tool.
struct CommonOptions {
  int threads = 0;  // 0: all cores
  Device device;    // with as many threads
};

// A tool's command line. `options` fills the parser; `work` runs after parsing and returns the exit code.
// An Error becomes "TOOL: error: text" on stderr and its exit code; running out of memory or threads becomes exit code
// 3, other exceptions 70. `--help` and `--version` print to stdout and exit 0, usage errors exit 2.
struct ToolMain {
  std::string name;         // "pm-lift"
  std::string description;  // one sentence: what goes in, what comes out
  std::string footer;       // an example call and the records it reads and writes
  std::function<void(Command)> options;
  std::function<int(const CommonOptions&)> work;
  bool on_gpu = false;  // some of its work may be done by a GPU; else --device cuda is refused
};

// A subcommand of a tool that has several.
struct Subcommand {
  Command command;
  std::function<int(const CommonOptions&)> work;
};

int run_tool(int argc, char** argv, const ToolMain& tool);

}  // namespace physmas

#endif
