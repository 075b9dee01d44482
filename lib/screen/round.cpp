#include "screen/round.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "base/file.h"
#include "records/json.h"
#include "records/scene.h"
#include "screen/audit.h"
#include "screen/decide.h"

namespace fs = std::filesystem;

namespace physmas::screen {
namespace {

// A candidate of `round` with its records.
Executed load_one(const RoundFiles& files, const std::string& id, int round, const Inventory& inventory,
                  Provenance& provenance) {
  const std::string candidate_path = join_path(files.candidates, id + ".json");
  const std::string execution_path = join_path(files.rollouts, id + ".json");
  const std::string render_path = join_path(files.videos, id + ".json");
  Executed executed;
  executed.candidate = load_candidate(candidate_path, id, inventory);
  if (executed.candidate.round != round) {
    throw invalid_field(candidate_path, "/round", executed.candidate.round,
                        std::to_string(round) + ", as its round record");
  }
  for (const std::string& input : {files.evidence, files.plan, files.inventory})
    require_made_from(candidate_path, input, false);
  const std::string rollout_path = join_path(files.rollouts, id + ".h5");
  executed.execution = load_execution_of(rollout_path);
  if (executed.execution.candidate != id)
    throw invalid_field(execution_path, "/candidate", executed.execution.candidate, "\"" + id + "\"");
  require_made_from(execution_path, candidate_path, true);
  require_same_state(execution_path, candidate_path);
  executed.render = load_render(render_path);
  if (executed.render.candidate != id)
    throw invalid_field(render_path, "/candidate", executed.render.candidate, "\"" + id + "\"");
  for (const std::string& input : {execution_path, rollout_path}) require_made_from(render_path, input, false);
  // One that is gone is the audit's to tell, where it is the accepted one.
  const std::string video = executed.render.video.empty() ? "" : join_path(files.videos, executed.render.video);
  std::error_code failure;
  if (fs::exists(video, failure)) require_written_with(render_path, video);
  for (const std::string& input : {candidate_path, execution_path, render_path}) provenance.add_input(input);
  return executed;
}

void copy_video(const std::string& from, const std::string& to) {
  AtomicFile out(to, ".mp4");
  std::error_code failure;
  fs::copy_file(from, out.temporary_path(), fs::copy_options::overwrite_existing, failure);
  if (failure) throw system_error(to, "cannot be written", failure.value());
  out.commit();
}

// accepted.json and final.mp4, where they were asked for.
void publish(const RoundFiles& files, const ScreenRecord& record, const Executed& executed, int frames) {
  const std::string video = join_path(files.videos, executed.render.video);
  if (!files.final_video.empty()) copy_video(video, files.final_video);
  if (files.accepted.empty()) return;
  const std::string& id = record.accepted;
  const std::string folder = folder_of(files.accepted);
  AcceptedRecord accepted;
  accepted.candidate = id;
  accepted.round = record.round;
  for (const ScreenedCandidate& c : record.candidates) {
    if (c.id == id) accepted.score = c.score;
  }
  accepted.video = portable_path(files.final_video.empty() ? video : files.final_video, folder);
  accepted.frames = frames;
  const std::vector<std::pair<std::string, std::string>> trail = {
      {"inventory", files.inventory},
      {"plan", files.plan},
      {"evidence", files.evidence},
      {"candidate", join_path(files.candidates, id + ".json")},
      {"execution", join_path(files.rollouts, id + ".json")},
      {"rollout", join_path(files.rollouts, id + ".h5")},
      {"render", join_path(files.videos, id + ".json")},
      {"screen", files.out}};
  Provenance provenance;
  provenance.tool = "pm-screen";
  for (const auto& [role, file] : trail) {
    provenance.add_input(file);
    accepted.audit.emplace_back(role, portable_path(file, folder));
  }
  provenance.add_input(video);
  if (!files.final_video.empty()) provenance.add_output(files.final_video);
  save_accepted(files.accepted, accepted, provenance);
}

// What an earlier run accepted does not hold any more.
void withdraw(const RoundFiles& files) {
  std::error_code failure;
  for (const std::string& file : {files.accepted, files.final_video}) {
    if (!file.empty()) fs::remove(file, failure);
  }
}

}  // namespace

std::vector<Executed> load_executed(const RoundFiles& files, int round, const Inventory& inventory,
                                    Provenance& provenance) {
  std::vector<Executed> all;
  std::set<std::string> seen;
  for (int k = 0; k <= round; ++k) {
    const std::string path = join_path(files.candidates, "round" + std::to_string(k) + ".json");
    const CandidateRound record = load_round(path);
    if (record.round != k) throw invalid_field(path, "/round", record.round, std::to_string(k));
    provenance.add_input(path);
    for (const std::string& id : record.ids) {
      if (!seen.insert(id).second) throw invalid_field(path, "/candidates", id, "an id that no earlier round has");
      all.push_back(load_one(files, id, k, inventory, provenance));
    }
  }
  if (all.empty()) {
    throw invalid_input({join_path(files.candidates, "round0.json"), "/candidates", "no candidate", "at least one"});
  }
  return all;
}

ScreenRecord screen_round(const RoundFiles& files, int round) {
  Provenance provenance;
  provenance.tool = "pm-screen";
  provenance.options = {{"round", std::to_string(round)}};
  for (const std::string& input : {files.scene, files.plan, files.evidence, files.inventory})
    provenance.add_input(input);
  const Scene scene = load_scene(files.scene, {});
  const RunSpecification& run = scene.run;
  if (round >= run.screening.rounds) {
    throw Error(ExitCode::usage, fmt::format("--round {}: the run specification allows {} rounds, expected 0..{}",
                                             round, run.screening.rounds, run.screening.rounds - 1));
  }
  const Inventory inventory = load_inventory(files.inventory);
  const Plan plan = load_plan(files.plan, inventory);
  const Evidence evidence = load_evidence(files.evidence, inventory.row_keys());
  for (const std::string& record : {files.plan, files.evidence}) require_made_from(record, files.inventory, false);
  const std::vector<Executed> executed = load_executed(files, round, inventory, provenance);

  const SceneRecords records{inventory,
                             evidence,
                             plan,
                             run.time.frames,
                             run.screening.tau,
                             run.screening.weights,
                             run.screening.excuse_rotation,
                             run.screening.achieved_min,
                             run.screening.stillness_min};
  ScreenRecord record = decide_round(executed, records, round, run.screening.rounds);
  const std::string chosen = record.accepted;
  const auto best =
      std::find_if(executed.begin(), executed.end(), [&](const Executed& e) { return e.candidate.id == chosen; });
  if (best != executed.end()) {
    audit_accepted(record, *best, records,
                   best->render.video.empty() ? "" : join_path(files.videos, best->render.video));
  }
  save_screen(files.out, record, provenance);
  // The decision for make, which builds the next round's part of the graph from it.
  write_file(fs::path(files.out).replace_extension(".mk").string(),
             fmt::format("PM_DECISION{} := {}\n", record.round, record.decision));
  if (record.decision == "accept") {
    publish(files, record, *best, run.time.frames);
  } else {
    withdraw(files);
  }
  return record;
}

}  // namespace physmas::screen
