// Whether a finished run is what was recorded: every file that the records of a run name by a hash, from what was accepted
// back to the bundle.
#ifndef PHYSMAS_SCREEN_RUN_AUDIT_H
#define PHYSMAS_SCREEN_RUN_AUDIT_H

#include <string>
#include <vector>

namespace physmas::screen {

struct RunAudit {
  struct Finding {
    std::string file;  // relative to the run
    std::string what;  // one line
  };
  int files = 0;                     // that were read and are what was recorded
  std::vector<Finding> wrong;        // are missing, hold other bytes, or say something else than another record
  std::vector<std::string> outside;  // named, but no files of the run, and not found: an example's description, say
  std::string root_sha256;           // of accepted.json, or of the last screen: nothing names it, so keep this number
};

// Reads a run's folder; changes nothing. A folder without a finished run is an Error (exit code 3).
RunAudit audit_run(const std::string& run);

// For a person, a line per finding.
std::string audit_text(const std::string& run, const RunAudit& audit);

}  // namespace physmas::screen

#endif
