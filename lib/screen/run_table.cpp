#include "screen/run_table.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "base/file.h"
#include "records/execution.h"
#include "records/json.h"
#include "records/render.h"
#include "records/screen.h"

namespace physmas::screen {
namespace {

namespace fs = std::filesystem;

constexpr int kRounds = 3;  // the most that a run has

bool exists(const std::string& path) {
  std::error_code failure;
  return fs::is_regular_file(path, failure);
}

std::string last_error_line(const std::string& log) {
  std::istringstream lines(exists(log) ? read_file(log) : "");
  std::string line, last;
  // A tool's own line says more than make's line about it.
  while (std::getline(lines, line)) {
    const bool of_a_tool = line.find("error:") != std::string::npos;
    if (of_a_tool || (last.empty() && line.find("***") != std::string::npos)) last = line;
  }
  return last.empty() ? "no screen record" : one_line(last, 300);
}

double total_seconds(const Json& runtime) {
  const Json::json_pointer total("/seconds/total");
  return runtime.contains(total) && runtime.at(total).is_number() ? runtime.at(total).get<double>() : 0;
}

void add_candidate_times(RunSummary& run, const std::string& folder, const ScreenedCandidate& candidate) {
  run.simulate_seconds +=
      total_seconds(load_execution(join_path(folder, "rollouts/" + candidate.id + ".json")).runtime);
  run.render_seconds += total_seconds(load_render(join_path(folder, "videos/" + candidate.id + ".json")).runtime);
}

void read_screen(RunSummary& run, const std::string& folder) {
  int last = -1;
  // A later record may be left from before the scene changed: the run ends with the first round that asks for no
  // repair.
  for (int k = 0; k < kRounds && exists(join_path(folder, fmt::format("screen/round{}.json", k))); ++k) {
    last = k;
    if (load_screen(join_path(folder, fmt::format("screen/round{}.json", k))).decision != "repair") break;
  }
  if (last < 0) return;
  const ScreenRecord record = load_screen(join_path(folder, fmt::format("screen/round{}.json", last)));
  run.rounds = last + 1;
  run.candidates = static_cast<int>(record.candidates.size());
  run.candidate = record.accepted;
  run.reason = record.reason;
  run.result = record.decision == "accept" ? "accepted" : record.decision == "fail" ? "none admitted" : "failed";
  for (const ScreenedCandidate& c : record.candidates) {
    if (record.accepted.empty() ? c.rank == 1 : c.id == record.accepted) run.score = c.score;
    add_candidate_times(run, folder, c);
  }
}

}  // namespace

RunSummary summarise_run(const std::string& folder) {
  RunSummary run;
  run.name = fs::path(folder).filename().string();
  run.result = "failed";
  int exit = 0;
  try {
    if (exists(join_path(folder, "batch.status"))) {
      std::istringstream status(read_file(join_path(folder, "batch.status")));
      status >> exit >> run.seconds;
    }
    read_screen(run, folder);
    // A make that failed for another reason than its verdict leaves records of an earlier call at best.
    if (run.result == "failed" || (exit != 0 && run.result == "accepted")) {
      run.result = "failed";
      run.candidate.clear();
      run.reason = last_error_line(join_path(folder, "log.txt"));
    }
  } catch (const Error& e) {
    run.result = "failed";
    run.candidate.clear();
    run.reason = e.what();
  }
  return run;
}

std::string run_table(const std::vector<RunSummary>& runs) {
  std::string table = "scene\tresult\tcandidate\trounds\tcandidates\tQ\tseconds\tsimulate_s\trender_s\treason\n";
  for (const RunSummary& r : runs) {
    table += fmt::format("{}\t{}\t{}\t{}\t{}\t{:.4f}\t{:.2f}\t{:.2f}\t{:.2f}\t{}\n", one_line(r.name),
                         one_line(r.result), r.candidate.empty() ? "-" : one_line(r.candidate), r.rounds, r.candidates,
                         r.score, r.seconds, r.simulate_seconds, r.render_seconds, one_line(r.reason));
  }
  return table;
}

}  // namespace physmas::screen
