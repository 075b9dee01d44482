// The one error type of PhysMAS, and the exit codes that every tool shares.
#ifndef PHYSMAS_BASE_ERROR_H
#define PHYSMAS_BASE_ERROR_H

#include <stdexcept>
#include <string>

namespace physmas {

// Exit codes are public: scripts and makefiles branch on them.
enum class ExitCode : int {
  done = 0,
  usage = 2,            // the command line is wrong
  invalid_input = 3,    // a file, a field, or a place to write to is wrong
  provider_failed = 4,  // a remote model did not answer usably
  diverged = 5,         // the simulation diverged and --strict was given
  no_admissible = 6,    // no candidate was admitted
  internal = 70         // a fault of ours
};

// An error that ends a tool: `what()` is one line, without the tool's name and without a newline.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

// What is wrong with an input, in the four parts that a message needs. Empty parts are left out.
struct Finding {
  std::string file;      // path as the user gave it
  std::string field;     // JSON pointer, HDF5 dataset, PLY property, or byte position
  std::string found;     // what is there
  std::string expected;  // what should be there
  std::string fix = {};  // what the user can do about it, if known
};

// "FILE: FIELD: found FOUND, expected EXPECTED; FIX", exit code 3.
Error invalid_input(const Finding& finding);

// A fault of ours (a broken invariant), exit code 70.
Error internal_error(const std::string& message);

// "FILE: DOING: system's text", exit code 3. `doing` is a verb phrase such as "cannot be written".
Error system_error(const std::string& file, const std::string& doing, int error_number);

// One line of UTF-8: control characters and newlines become spaces, bytes that are no UTF-8 question marks; long text
// is cut after `limit` bytes and the character that they end in, with an ellipsis.
std::string one_line(const std::string& text, size_t limit = 400);

// Number of characters of a text in UTF-8, or -1 where it is none.
long utf8_length(const std::string& text);

}  // namespace physmas

#endif
