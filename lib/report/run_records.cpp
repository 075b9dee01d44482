#include "report/run_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas::report {
namespace {

bool exists(const std::string& path) {
  std::error_code failure;
  return fs::is_regular_file(path, failure);
}

class Loader {
 public:
  explicit Loader(const std::string& folder) { run_.folder = folder; }

  RunRecords load() {
    if (!has("spec/render.json"))
      throw invalid_input(
          {run_.folder, "", "no spec/render.json", "the folder of a run", "make run RUN=" + run_.folder});
    run_.scene = load_scene(use("spec/render.json"), {});
    load_grounding();
    if (has("state.h5") && run_.inventory) {
      run_.state = load_state(use("state.h5"), &*run_.inventory);
      omissions("state.h5", run_.state->omitted);
    }
    if (has("evidence.json") && run_.inventory) {
      run_.evidence = load_evidence(use("evidence.json"), run_.inventory->row_keys());
      omissions("evidence.json", run_.evidence->omitted);
    }
    load_rounds();
    load_settings();
    load_request();
    load_error();
    load_times();
    choose_shown();
    return std::move(run_);
  }
  RunRecords load_only_request() {
    load_request();
    return std::move(run_);
  }

 private:
  bool has(const std::string& relative) const { return exists(join_path(run_.folder, relative)); }
  std::string use(const std::string& relative) {
    run_.files.push_back(relative);
    return join_path(run_.folder, relative);
  }
  void omissions(const std::string& file, const std::vector<Omission>& omitted) {
    for (const Omission& o : omitted) run_.omitted.emplace_back(file, o);
  }

  void load_grounding() {
    if (!has("inventory.json") || !has("plan.json")) return;
    const std::string inventory = use("inventory.json");
    run_.inventory = load_inventory(inventory);
    omissions("inventory.json", omissions_from(load_record(inventory, "inventory")));
    run_.plan = load_plan(use("plan.json"), *run_.inventory);
    run_.prompt = run_.plan->prompt;
    omissions("plan.json", run_.plan->omitted);
  }

  void load_rounds() {
    for (int n = 0; n < 3; ++n) {
      const std::string file = fmt::format("candidates/round{}.json", n);
      if (!has(file) || !run_.inventory) break;
      const CandidateRound round = load_round(use(file));
      omissions(file, round.omitted);
      for (const std::string& id : round.ids) load_attempt(id);
      const std::string screen = fmt::format("screen/round{}.json", n);
      if (!has(screen)) break;
      run_.screen = load_screen(use(screen));
      run_.screen_file = screen;
      if (run_.screen->decision != "repair") break;
    }
    if (!run_.screen) return;
    run_.accepted = run_.screen->accepted;
    omissions(run_.screen_file, run_.screen->omitted);
    for (RunRecords::Attempt& attempt : run_.attempts) {
      for (const ScreenedCandidate& c : run_.screen->candidates) {
        if (c.id == attempt.candidate.id) attempt.screened = &c;
      }
    }
    std::stable_sort(run_.attempts.begin(), run_.attempts.end(), [](const auto& a, const auto& b) {
      return (a.screened != nullptr ? a.screened->rank : 1000) < (b.screened != nullptr ? b.screened->rank : 1000);
    });
  }

  void load_attempt(const std::string& id) {
    const std::string file = "candidates/" + id + ".json";
    if (!has(file)) return;
    RunRecords::Attempt attempt;
    attempt.candidate = load_candidate(use(file), id, *run_.inventory);
    omissions(file, attempt.candidate.omitted);
    const std::string execution = "rollouts/" + id + ".json", render = "videos/" + id + ".json";
    if (has(execution)) {
      attempt.execution = load_execution(use(execution));
      omissions(execution, attempt.execution->omitted);
    }
    if (has(render)) {
      attempt.render = load_render(use(render));
      omissions(render, attempt.render->omitted);
      // Two names of a file in that folder, whatever the record says.
      const std::string video = "videos/" + id + ".mp4";
      if (!attempt.render->video.empty() && has(video)) {
        require_written_with(join_path(run_.folder, render), use(video));
        attempt.video = video;
      }
    }
    run_.attempts.push_back(std::move(attempt));
  }

  // An estimate of another rollout, as an earlier run left it, is none of this one.
  void load_error() {
    if (!has("error.json") || run_.accepted.empty()) return;
    const std::string path = join_path(run_.folder, "error.json");
    const Json error = load_record(path, "error");
    const std::string rollout = join_path(run_.folder, "rollouts/" + run_.accepted + ".h5");
    if (error.at("candidate").get<std::string>() != run_.accepted || !exists(rollout)) return;
    const std::string made_of = sha256_file(rollout);
    for (const Provenance::Input& input : recorded_files(path).inputs) {
      if (input.sha256 == made_of) run_.error = error;
    }
    if (run_.error) run_.files.push_back("error.json");
  }

  // The slices hold all settings, each stage's own.
  void load_settings() {
    const Json defaults = to_json(RunSpecification());
    Json merged = Json::object();
    for (const char* stage : {"ground", "lift", "material", "candidates", "simulate", "render", "screen"}) {
      const std::string file = fmt::format("spec/{}.json", stage);
      if (!has(file)) continue;
      const Json document = load_record(join_path(run_.folder, file), "scene");
      if (file != "spec/render.json") run_.files.push_back(file);
      if (run_.prompt.empty() && document.contains("prompt")) run_.prompt = document.at("prompt").get<std::string>();
      if (document.contains("run")) merged.merge_patch(document.at("run"));
    }
    compare(merged, defaults, "");
  }
  void compare(const Json& value, const Json& standard, const std::string& at) {
    for (const auto& [key, part] : value.items()) {
      const std::string name = at.empty() ? key : at + "." + key;
      if (key == "schema") continue;
      const Json other = standard.is_object() && standard.contains(key) ? standard.at(key) : Json();
      if (part.is_object() && other.is_object())
        compare(part, other, name);
      else if (part != other)
        run_.settings.emplace_back(name, std::make_pair(part, other));
    }
  }

  // make's notes: "NAME=value" on lines of which all but the first are set in by a blank.
  void load_request() {
    for (const char* file : {"source", "request", "changes", "ground-models", "models", "settings"}) {
      if (!has(file)) continue;
      std::istringstream lines(read_file(join_path(run_.folder, file), 1 << 20));
      std::string line;
      if (std::string(file) == "settings") {
        std::string word, set;
        while (lines >> word) {
          if (word == "default") {
            lines >> word;
            continue;
          }
          set += (set.empty() ? "" : " ") + word;
        }
        if (!set.empty()) run_.request.emplace_back("SET", set);
        continue;
      }
      while (std::getline(lines, line)) {
        line.erase(0, line.find_first_not_of(' '));
        const size_t equals = line.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == line.size()) continue;
        const std::string name = line.substr(0, equals);
        if (name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos) continue;
        const bool known =
            std::any_of(run_.request.begin(), run_.request.end(), [&](const auto& r) { return r.first == name; });
        if (!known) run_.request.emplace_back(name, line.substr(equals + 1));
      }
    }
  }

  void load_times() {
    std::vector<std::string> stages = {"bundle", "spec", "ground", "lift", "material"};
    for (int n = 0; n < 3; ++n) {
      stages.push_back(fmt::format("candidates{}", n));
      for (const char* what : {"simulate", "camera", "render"}) {
        if (std::string(what) == "camera") {
          stages.push_back(fmt::format("camera{}", n));
          continue;
        }
        for (const RunRecords::Attempt& a : run_.attempts) {
          if (a.candidate.round == n) stages.push_back(fmt::format("{}-{}", what, a.candidate.id));
        }
      }
      stages.push_back(fmt::format("screen{}", n));
    }
    stages.insert(stages.end(), {"best", "error"});
    for (const std::string& stage : stages) {
      if (const auto time = read_stage_time(join_path(run_.folder, ".stamps/" + stage)))
        run_.times.emplace_back(stage, *time);
    }
  }

  void choose_shown() {
    for (const RunRecords::Attempt& a : run_.attempts) {
      if (run_.accepted.empty() ? (run_.shown == nullptr && !a.video.empty()) : a.candidate.id == run_.accepted)
        run_.shown = &a;
    }
    if (run_.shown == nullptr && !run_.attempts.empty()) run_.shown = &run_.attempts.front();
    const std::string own = run_.accepted.empty() ? "best.mp4" : "final.mp4";
    if (has(own) && run_.screen) {
      run_.shown_video = own;
      run_.files.push_back(own);
    } else if (run_.shown != nullptr) {
      run_.shown_video = run_.shown->video;
    }
  }

  RunRecords run_;
};

}  // namespace

std::string RunRecords::path(const std::string& relative) const {
  return join_path(folder, relative);
}

RunRecords load_run(const std::string& folder) {
  return Loader(folder).load();
}

RunRecords load_request(const std::string& folder) {
  return Loader(folder).load_only_request();
}

}  // namespace physmas::report
