// What a run's folder holds, for a person to be shown: as much of it as there is.
#ifndef PHYSMAS_REPORT_RUN_RECORDS_H
#define PHYSMAS_REPORT_RUN_RECORDS_H

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/stage_notes.h"
#include "records/candidate.h"
#include "records/evidence.h"
#include "records/execution.h"
#include "records/plan.h"
#include "records/render.h"
#include "records/scene.h"
#include "records/screen.h"
#include "records/state.h"

namespace physmas::report {

// Files that a run did not come to are empty here; what is there must be sound, and what belongs together is.
struct RunRecords {
  struct Attempt {  // one candidate
    Candidate candidate;
    std::optional<ExecutionRecord> execution;
    std::optional<RenderRecord> render;
    const ScreenedCandidate* screened = nullptr;
    std::string video;  // relative to the folder; empty: none
  };

  std::string folder;
  // By stage, as make noted them (base/stage_notes.h): those that took part, in the order of the run.
  std::vector<std::pair<std::string, StageTime>> times;
  std::vector<std::string> files;  // that were read, relative to the folder, in the order of reading
  std::optional<Scene> scene;      // spec/render.json
  std::string prompt;
  std::optional<Inventory> inventory;
  std::optional<Plan> plan;
  std::optional<Evidence> evidence;
  std::optional<State> state;
  std::optional<ScreenRecord> screen;  // the last round's
  std::string screen_file;
  std::vector<Attempt> attempts;  // by rank, where there is a screen; else by round and order
  // What was asked for, as make noted it: variable and value, without those that are empty.
  std::vector<std::pair<std::string, std::string>> request;
  // Run settings that are not the defaults: "grid.n" -> its value and the default.
  std::vector<std::pair<std::string, std::pair<Json, Json>>> settings;
  std::vector<std::pair<std::string, Omission>> omitted;  // with the file that says so
  std::string accepted;                                   // candidate
  std::optional<Json> error;  // error.json, where it is the accepted candidate's as it stands here
  // The candidate that is shown: the accepted one, else the best that did not diverge. Null: none was executed.
  const Attempt* shown = nullptr;
  std::string shown_video;  // final.mp4, best.mp4 or a candidate's; empty: none

  std::string path(const std::string& relative) const;
};

// Errors (exit code 3): no folder, not a run's (nothing in spec/), or a record that is damaged or names other bytes
// than are there.
RunRecords load_run(const std::string& folder);
// Of a run that has no scene yet, or one whose records cannot be read: what it was asked for.
RunRecords load_request(const std::string& folder);

}  // namespace physmas::report

#endif
