#include "screen/run_audit.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"
#include "records/provenance.h"
#include "records/screen.h"
#include "remote/exchange.h"

namespace fs = std::filesystem;

namespace physmas::screen {
namespace {

// Files of a run that other records name by their bare name, with the record of the HDF5 ones.
const std::map<std::string, std::string> kOwnFiles = {
    {"inventory.json", ""}, {"plan.json", ""}, {"evidence.json", ""}, {"masks.h5", "masks"},
    {"state.h5", "state"},  {"final.mp4", ""}, {"best.mp4", ""}};

// Nothing where the exchange contradicts its own hashes.
std::string hash_of_exchange(const std::string& path) {
  try {
    return remote::load_exchange(path).sha256();
  } catch (const Error&) {
    return "";
  }
}

class Auditor {
 public:
  explicit Auditor(const std::string& run) : run_(run) {}

  RunAudit audit() {
    const std::string accepted = in_run("accepted.json");
    std::string screen;
    for (const char* name : {"screen/round2.json", "screen/round1.json", "screen/round0.json"}) {
      if (screen.empty() && exists(in_run(name))) screen = name;
    }
    const bool has_accepted = exists(accepted);
    if (screen.empty() && !has_accepted)
      throw invalid_input(
          {run_, "", "no screen/roundN.json", "the folder of a run that has ended", "make run RUN=" + run_});
    audit_.root_sha256 = sha256_file(has_accepted ? accepted : in_run(screen));
    if (!screen.empty()) follow_record(screen);
    if (has_accepted) follow_record("accepted.json");
    if (exists(in_run("report.json"))) follow_record("report.json");
    try {
      if (!screen.empty()) compare_decision(screen, has_accepted);
    } catch (const Error& e) {
      wrong(has_accepted ? "accepted.json" : screen, e.what());
    }
    for (const auto& [name, sha256] : missing_) {
      if (known_hashes_.count(sha256) == 0) audit_.outside.push_back(name);
    }
    audit_.files = static_cast<int>(right_.size());
    return audit_;
  }

 private:
  std::string in_run(const std::string& relative) const { return join_path(run_, relative); }

  static bool exists(const std::string& path) {
    std::error_code failure;
    return fs::exists(path, failure);
  }

  void wrong(const std::string& file, const std::string& what) {
    if (reported_.insert(file + "\n" + what).second) audit_.wrong.push_back({file, one_line(what)});
  }

  // A file that somebody names: looked at once for each hash that it is given, and what it names in turn.
  // is_near: it lies where its name says.
  void follow(const std::string& folder, const Provenance::Input& named, const std::string& by, bool is_near) {
    const std::string file = (fs::path(folder) / named.path).lexically_normal().generic_string();
    const bool bare = named.path.find('/') == std::string::npos;
    if (!exists(in_run(file))) {
      // What lies far from the run is named without its folder; the slices name the bundle's files with theirs.
      if (!is_near && bare && kOwnFiles.count(file) == 0) {
        missing_.emplace_back(file, named.sha256);
      } else {
        wrong(file, "is not there; " + by + " names it");
      }
      return;
    }
    if (!seen_.insert(file + "\n" + named.sha256).second) return;
    try {
      if (!is_unchanged(in_run(file), named)) {
        wrong(file, fmt::format("is not what {} was made with: SHA-256 {}, recorded {}", by,
                                named.without_runtime ? sha256_of_record(in_run(file)) : sha256_file(in_run(file)),
                                named.sha256));
        return;
      }
    } catch (const Error& e) {
      wrong(file, e.what());
      return;
    }
    right_.insert(file);
    known_hashes_.insert(named.sha256);
    follow_record(file);
  }

  // What a file names, if it is a record of this run. It has been compared, or is where the audit starts.
  void follow_record(const std::string& file) {
    const fs::path path(file);
    const std::string folder = path.parent_path().generic_string();
    if ((path.extension() != ".json" && path.extension() != ".h5") || !followed_.insert(file).second) return;
    // The bundle is what the run starts from.
    if (folder == "bundle" || folder.rfind("..", 0) == 0) return;
    try {
      const auto own = kOwnFiles.find(file);
      const RecordedFiles named = recorded_files(in_run(file), own == kOwnFiles.end() ? "rollout" : own->second);
      for (const auto* list : {&named.inputs, &named.outputs}) {
        for (const Provenance::Input& input : *list) follow(folder, input, file, list == &named.outputs);
      }
      if (path.extension() == ".json") follow_document(file, folder);
    } catch (const Error& e) {
      wrong(file, e.what());
    }
  }

  // Hashes beside the provenance: the bundle's files in a slice, recorded exchanges.
  void follow_document(const std::string& file, const std::string& folder) {
    const Json document = parse_json(read_file(in_run(file)), in_run(file));
    if (document.value("schema", "") == "physmas/scene/1" && document.contains("files")) {
      const std::string root = (fs::path(folder) / document.value("root", ".")).lexically_normal().generic_string();
      for (const auto& [name, sha256] : document.at("files").items())
        follow(root, {name, sha256.get<std::string>(), false}, file, true);
    }
    for (const ExchangeReference& exchange : exchanges_from(document)) {
      const std::string name = "exchanges/" + exchange.name + ".json";
      if (!exists(in_run(name))) {
        // A replay leaves them where they were recorded.
        if (exists(in_run("exchanges")))
          wrong(name, "is not there; " + file + " rests on it");
        else
          audit_.outside.push_back(name);
        continue;
      }
      if (hash_of_exchange(in_run(name)) == exchange.sha256) {
        right_.insert(name);
      } else {
        wrong(name, "is not what was recorded: " + file + " rests on another exchange");
      }
    }
  }

  void compare_decision(const std::string& screen_file, bool has_accepted) {
    const ScreenRecord screen = load_screen(in_run(screen_file));
    if (screen.decision == "repair") wrong(screen_file, "asks for repairs: the run has not ended");
    if (has_accepted != (screen.decision == "accept")) {
      wrong("accepted.json", has_accepted ? "is there, but " + screen_file + " accepts nothing"
                                          : "is not there; " + screen_file + " accepts " + screen.accepted);
      return;
    }
    if (!has_accepted) return;
    const AcceptedRecord accepted = load_accepted(in_run("accepted.json"));
    if (accepted.candidate != screen.accepted)
      wrong("accepted.json",
            fmt::format("accepts {}, {} accepts {}", accepted.candidate, screen_file, screen.accepted));
    for (const ScreenedCandidate& c : screen.candidates) {
      if (c.id == screen.accepted && c.score != accepted.score)
        wrong("accepted.json", fmt::format("gives the score {}, {} gives {}", accepted.score, screen_file, c.score));
    }
    // The video that is shown is that of the candidate.
    const std::string video = "videos/" + accepted.candidate + ".mp4";
    for (const std::string& file : {video, accepted.video}) {
      if (!exists(in_run(file))) wrong(file, "is not there; accepted.json names it");
    }
    if (exists(in_run(video)) && exists(in_run(accepted.video)) &&
        sha256_file(in_run(video)) != sha256_file(in_run(accepted.video)))
      wrong(accepted.video, "is not the video of " + accepted.candidate);
  }

  std::string run_;
  RunAudit audit_;
  std::set<std::string> seen_, followed_, right_, reported_, known_hashes_;
  std::vector<std::pair<std::string, std::string>> missing_;  // bare name and hash
};

}  // namespace

RunAudit audit_run(const std::string& run) {
  return Auditor(run).audit();
}

std::string audit_text(const std::string& run, const RunAudit& audit) {
  std::string text;
  for (const RunAudit::Finding& finding : audit.wrong) text += one_line(finding.file) + ": " + finding.what + "\n";
  for (const std::string& file : audit.outside) text += one_line(file) + ": outside of the run, not compared\n";
  return text + fmt::format("{}: {} files are what was recorded, {} are not; {} has SHA-256 {}\n", one_line(run),
                            audit.files, audit.wrong.size(), "its last record", audit.root_sha256);
}

}  // namespace physmas::screen
