// pm-screen: scores, gates and ranks the executed candidates, and decides the round.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <set>

#include "base/command_line.h"
#include "base/file.h"
#include "records/json.h"
#include "records/scene.h"
#include "screen/audit.h"
#include "screen/decide.h"
#include "screen/explain.h"
#include "screen/run_table.h"

using namespace physmas;
namespace fs = std::filesystem;

namespace {

struct Options {
  std::string scene, plan, evidence, inventory, candidates, rollouts, videos, out, accepted, final_video;
  int round = -1;
  bool explain = false;
  std::vector<std::string> table;
};

std::string in(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

void require(const std::string& value, const char* flag) {
  if (value.empty()) throw Error(ExitCode::usage, std::string(flag) + " is required; see pm-screen --help");
}

void print(const std::string& text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  // A reader that has seen enough (`| head`) is no error.
  if (!written && errno != EPIPE) throw system_error("standard output", "cannot be written", errno);
}

// A candidate of `round` with its records; they must belong together.
screen::Executed load_executed(const Options& options, const std::string& id, int round, const Inventory& inventory,
                               Provenance& provenance) {
  const std::string candidate_path = in(options.candidates, id + ".json");
  const std::string execution_path = in(options.rollouts, id + ".json");
  const std::string render_path = in(options.videos, id + ".json");
  screen::Executed executed;
  executed.candidate = load_candidate(candidate_path);
  const Candidate& candidate = executed.candidate;
  if (candidate.id != id) throw invalid_field(candidate_path, "/id", candidate.id, "\"" + id + "\"");
  if (candidate.round != round)
    throw invalid_field(candidate_path, "/round", candidate.round, std::to_string(round) + ", as its round record");
  for (size_t i = 0; i < candidate.rows.size(); ++i) {
    const CandidateRow& row = candidate.rows[i];
    if (row.row >= static_cast<int>(inventory.rows.size()) || inventory.rows[row.row].key() != row.key)
      throw invalid_field(candidate_path, "/rows/" + std::to_string(i) + "/key", row.key,
                          "the inventory's key of this row");
  }
  require_made_from(candidate_path, options.evidence, false);
  executed.execution = load_execution(execution_path);
  if (executed.execution.candidate != id)
    throw invalid_field(execution_path, "/candidate", executed.execution.candidate, "\"" + id + "\"");
  require_made_from(execution_path, candidate_path, true);
  require_same_state(execution_path, candidate_path);
  executed.render = load_render(render_path);
  if (executed.render.candidate != id)
    throw invalid_field(render_path, "/candidate", executed.render.candidate, "\"" + id + "\"");
  for (const std::string& input : {candidate_path, execution_path, render_path}) provenance.add_input(input);
  return executed;
}

// Every candidate of rounds 0..N, first appearance first.
std::vector<screen::Executed> load_all(const Options& options, const Inventory& inventory, Provenance& provenance) {
  std::vector<screen::Executed> all;
  std::set<std::string> seen;
  for (int k = 0; k <= options.round; ++k) {
    const std::string path = in(options.candidates, "round" + std::to_string(k) + ".json");
    const CandidateRound round = load_round(path);
    if (round.round != k) throw invalid_field(path, "/round", round.round, std::to_string(k));
    provenance.add_input(path);
    for (const std::string& id : round.ids) {
      if (!seen.insert(id).second) throw invalid_field(path, "/candidates", id, "an id that no earlier round has");
      all.push_back(load_executed(options, id, k, inventory, provenance));
    }
  }
  if (all.empty()) {
    throw invalid_input({in(options.candidates, "round0.json"), "/candidates", "no candidate", "at least one"});
  }
  return all;
}

void copy_video(const std::string& from, const std::string& to) {
  AtomicFile out(to, ".mp4");
  std::error_code failure;
  fs::copy_file(from, out.temporary_path(), fs::copy_options::overwrite_existing, failure);
  if (failure) throw system_error(to, "cannot be written", failure.value());
  out.commit();
}

// accepted.json and final.mp4, where they were asked for.
void publish(const Options& options, const ScreenRecord& record, const screen::Executed& executed, int frames) {
  const std::string video = in(options.videos, executed.render.video);
  if (!options.final_video.empty()) copy_video(video, options.final_video);
  if (options.accepted.empty()) return;
  const std::string& id = record.accepted;
  const std::string folder = folder_of(options.accepted);
  AcceptedRecord accepted;
  accepted.candidate = id;
  accepted.round = record.round;
  for (const ScreenedCandidate& c : record.candidates) {
    if (c.id == id) accepted.score = c.score;
  }
  accepted.video = portable_path(options.final_video.empty() ? video : options.final_video, folder);
  accepted.frames = frames;
  const std::vector<std::pair<std::string, std::string>> trail = {{"inventory", options.inventory},
                                                                  {"plan", options.plan},
                                                                  {"evidence", options.evidence},
                                                                  {"candidate", in(options.candidates, id + ".json")},
                                                                  {"execution", in(options.rollouts, id + ".json")},
                                                                  {"rollout", in(options.rollouts, id + ".h5")},
                                                                  {"render", in(options.videos, id + ".json")},
                                                                  {"screen", options.out}};
  Provenance provenance;
  provenance.tool = "pm-screen";
  provenance.add_input(options.out);
  provenance.add_input(video);
  for (const auto& [role, file] : trail) accepted.audit.emplace_back(role, portable_path(file, folder));
  save_accepted(options.accepted, accepted, provenance);
}

// What an earlier run accepted does not hold any more.
void withdraw(const Options& options) {
  std::error_code failure;
  for (const std::string& file : {options.accepted, options.final_video}) {
    if (!file.empty()) fs::remove(file, failure);
  }
}

ScreenRecord screen_round(const Options& options) {
  Provenance provenance;
  provenance.tool = "pm-screen";
  provenance.options = {{"round", std::to_string(options.round)}};
  for (const std::string& input : {options.scene, options.plan, options.evidence, options.inventory})
    provenance.add_input(input);
  const Scene scene = load_scene(options.scene, {});
  const RunSpecification& run = scene.run;
  if (options.round >= run.screening.rounds) {
    throw Error(ExitCode::usage, fmt::format("--round {}: the run specification allows {} rounds, expected 0..{}",
                                             options.round, run.screening.rounds, run.screening.rounds - 1));
  }
  const Inventory inventory = load_inventory(options.inventory);
  const Plan plan = load_plan(options.plan, inventory);
  std::vector<std::string> keys;
  for (const InventoryRow& row : inventory.rows) keys.push_back(row.key());
  const Evidence evidence = load_evidence(options.evidence, keys);
  const std::vector<screen::Executed> executed = load_all(options, inventory, provenance);

  const screen::SceneRecords records{inventory,       evidence,          plan,
                                     run.time.frames, run.screening.tau, run.screening.weights};
  ScreenRecord record = screen::decide_round(executed, records, options.round, run.screening.rounds);
  const std::string chosen = record.accepted;
  const auto best = std::find_if(executed.begin(), executed.end(),
                                 [&](const screen::Executed& e) { return e.candidate.id == chosen; });
  if (best != executed.end()) {
    screen::audit_accepted(record, *best, records,
                           best->render.video.empty() ? "" : in(options.videos, best->render.video));
  }
  save_screen(options.out, record, provenance);
  // The decision for make, which builds the next round's part of the graph from it.
  write_file(fs::path(options.out).replace_extension(".mk").string(),
             fmt::format("PM_DECISION{} := {}\n", record.round, record.decision));
  if (record.decision == "accept") {
    publish(options, record, *best, run.time.frames);
  } else {
    withdraw(options);
  }
  return record;
}

int work(const Options& options) {
  require(options.out, "--out");
  if (!options.table.empty()) {
    std::vector<screen::RunSummary> runs;
    for (const std::string& run : options.table) runs.push_back(screen::summarise_run(run));
    write_file(options.out, screen::run_table(runs));
    return static_cast<int>(ExitCode::done);
  }
  // Only --out: print a record that is there.
  if (options.explain && options.scene.empty()) {
    print(screen::explain(load_screen(options.out)));
    return static_cast<int>(ExitCode::done);
  }
  for (const auto& [value, flag] :
       std::vector<std::pair<std::string, const char*>>{{options.scene, "--scene"},
                                                        {options.plan, "--plan"},
                                                        {options.evidence, "--evidence"},
                                                        {options.inventory, "--inventory"},
                                                        {options.candidates, "--candidates"},
                                                        {options.rollouts, "--rollouts"},
                                                        {options.videos, "--videos"}}) {
    require(value, flag);
  }
  if (options.round < 0) throw Error(ExitCode::usage, "--round is required; see pm-screen --help");
  const ScreenRecord record = screen_round(options);
  if (options.explain) print(screen::explain(record));
  if (record.decision == "fail") {
    throw Error(ExitCode::no_admissible, one_line(fmt::format("round {}: {}; pm-screen --explain --out {} shows why",
                                                              record.round, record.reason, options.out)));
  }
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ToolMain tool;
  tool.name = "pm-screen";
  tool.description =
      "Scores, gates and ranks the executed candidates of rounds 0..N and decides: accept, repair or fail.";
  tool.footer =
      "Example: pm-screen --scene scene.json --plan plan.json --evidence evidence.json --inventory inventory.json "
      "--candidates candidates --rollouts rollouts --videos videos --round 0 --out screen/round0.json "
      "--accepted accepted.json --final final.mp4\n"
      "Print a record: pm-screen --explain --out screen/round0.json\n"
      "Runs in a table: pm-screen --table runs/a runs/b --out table.tsv\n"
      "Reads physmas/scene, plan, evidence, inventory, round, candidate, execution, render; writes physmas/screen and, "
      "on acceptance, physmas/accepted and the video (both are removed when nothing is accepted). Exit code 6: no "
      "candidate was admitted in the last round, or the audit failed.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "scene.json or its slice").type_name("FILE");
    app.add_option("--plan", options.plan, "plan.json").type_name("FILE");
    app.add_option("--evidence", options.evidence, "evidence.json").type_name("FILE");
    app.add_option("--inventory", options.inventory, "inventory.json").type_name("FILE");
    app.add_option("--candidates", options.candidates, "Folder with roundK.json and ID.json").type_name("DIR");
    app.add_option("--rollouts", options.rollouts, "Folder with the execution records ID.json").type_name("DIR");
    app.add_option("--videos", options.videos, "Folder with the render records ID.json and the videos")
        .type_name("DIR");
    app.add_option("--round", options.round, "The round N that has been executed").between(0, 2);
    app.add_option("--out", options.out, "screen/roundN.json to write, or to print").type_name("FILE");
    app.add_option("--accepted", options.accepted, "accepted.json to write on acceptance").type_name("FILE");
    app.add_option("--final", options.final_video, "Copy of the accepted video to write").type_name("FILE");
    app.add_option("--table", options.table, "Folders of runs: write what became of them to --out, tab-separated")
        .type_name("DIR...");
    app.add_flag("--explain", options.explain, "Print the round as a table; with --out alone, a record that is there");
  };
  tool.work = [&](const CommonOptions&) { return work(options); };
  return run_tool(argc, argv, tool);
}
