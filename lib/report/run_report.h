// The page of a run: what happened, why this candidate, what else was tried, and how far it can be trusted.
#ifndef PHYSMAS_REPORT_RUN_REPORT_H
#define PHYSMAS_REPORT_RUN_REPORT_H

#include <string>
#include <vector>

namespace physmas::report {

struct ReportOptions {
  // Of a run that has just failed: the stage, as make calls it, and the exit status of its command. Empty: none has.
  std::string failed;
  int status = 0;
  std::string run;                   // the run's folder
  std::string out;                   // .html; the record goes beside it
  size_t viewer_bytes = 3 << 20;     // most that the stream of the viewer may take; 0: no viewer
  size_t candidate_bytes = 3 << 20;  // most that the candidates' videos may take together
};

// Writes the page and its record, from the records in the run's folder alone; the run need not have ended well, nor at
// all. The same records give the same bytes, but for run times, which stand between kPageRuntime. Errors (exit code 3)
// as load_run.
void write_run_report(const ReportOptions& options);

// A page with a row per run: what became of it, a picture, and a link to its report. Nothing throws for a run that is
// damaged: its row says so.
void write_run_index(const std::vector<std::string>& runs, const std::string& out);

}  // namespace physmas::report

#endif
