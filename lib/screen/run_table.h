// The table of a batch: what became of every run.
#ifndef PHYSMAS_SCREEN_RUN_TABLE_H
#define PHYSMAS_SCREEN_RUN_TABLE_H

#include <string>
#include <vector>

namespace physmas::screen {

struct RunSummary {
  std::string name;                                 // of the run's folder
  std::string result;                               // accepted | none admitted | failed
  std::string candidate;                            // accepted id, empty when none
  int rounds = 0;                                   // screened
  int candidates = 0;                               // executed
  double score = 0;                                 // Q of the accepted candidate, else of the best one; 0 without any
  double seconds = 0;                               // wall clock of this call of make; 0 when it is not known
  double simulate_seconds = 0, render_seconds = 0;  // sums over the executed candidates
  std::string reason;
};

// Reads a run's folder: the last screen record, execution and render records, and what `make batch` left there:
// batch.status ("exit code, wall seconds") and log.txt, whose last error line is the reason of a run that never came to
// its screen. Damaged records make a run `failed` with their message; nothing throws.
RunSummary summarise_run(const std::string& folder);

// Tab-separated, one header line; texts have no tabs.
std::string run_table(const std::vector<RunSummary>& runs);

}  // namespace physmas::screen

#endif
