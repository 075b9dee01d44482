// pm-candidates: executable configurations from material evidence and the plan, or the repairs of a screened round.
#include <filesystem>

#include "base/command_line.h"
#include "base/file.h"
#include "candidate/authored.h"
#include "candidate/build.h"
#include "candidate/one_material.h"
#include "records/json.h"
#include "records/scene.h"
#include "records/state.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, plan, evidence, state, out, repair, configuration;
};

// The evidence must belong to this state: its provenance where it has one, its counts always.
void check_evidence(const Options& options, const Evidence& evidence, const std::vector<long>& gaussians) {
  require_made_from(options.evidence, options.inventory, false);
  require_made_from(options.evidence, options.state, false);
  require_made_from(options.plan, options.inventory, false);
  require_made_from(options.state, options.inventory, false, "state");
  for (size_t r = 0; r < gaussians.size(); ++r) {
    if (evidence.rows[r].gaussians == gaussians[r]) continue;
    throw invalid_field(options.evidence, "/rows/" + std::to_string(r) + "/gaussians", evidence.rows[r].gaussians,
                        std::to_string(gaussians[r]) + ", as in " + options.state, "run pm-material again");
  }
}

std::string candidate_path(const Options& options, const std::string& id) {
  return (std::filesystem::path(options.out) / (id + ".json")).string();
}

// The candidates that the screen has seen, in its order.
std::vector<Candidate> load_seen(const Options& options, const ScreenRecord& screen, const Inventory& inventory) {
  std::vector<Candidate> seen;
  for (const ScreenedCandidate& screened : screen.candidates) {
    seen.push_back(load_candidate(candidate_path(options, screened.id), screened.id, inventory));
  }
  return seen;
}

void write_round(const Options& options, const candidate::Round& round, const Provenance& of_candidates,
                 const Provenance& of_round) {
  CandidateRound record;
  record.round = round.round;
  record.omitted = round.omitted;
  std::string fragment = "PM_ROUND" + std::to_string(round.round) + " :=";
  for (const Candidate& c : round.candidates) {
    save_candidate(candidate_path(options, c.id), c, of_candidates);
    record.ids.push_back(c.id);
    fragment += " " + c.id;
  }
  const std::string stem = (std::filesystem::path(options.out) / ("round" + std::to_string(round.round))).string();
  save_round(stem + ".json", record, of_round);
  write_file(stem + ".mk", fragment + "\n");
}

// One candidate, as the user wrote it.
int work_authored(const Options& options) {
  Provenance provenance;
  provenance.tool = "pm-candidates";
  for (const std::string& input : {options.scene, options.inventory, options.configuration, options.state})
    provenance.add_input(input);
  require_made_from(options.state, options.inventory, false, "state");
  const Scene scene = load_scene(options.scene, {});
  const Inventory inventory = load_inventory(options.inventory);
  const AuthoredConfiguration configuration = load_configuration(options.configuration, inventory);
  const std::vector<long> gaussians = load_state_rows(options.state, inventory).gaussians_per_row();
  candidate::Round round;
  round.candidates.push_back(
      candidate::authored_candidate(configuration, inventory, scene.run, gaussians, options.configuration));
  write_round(options, round, provenance, provenance);
  return static_cast<int>(ExitCode::done);
}

int work(const Options& options) {
  if (!options.configuration.empty()) return work_authored(options);
  if (options.plan.empty() || options.evidence.empty())
    throw Error(ExitCode::usage, "--plan and --evidence are required, or --configuration instead of both");
  Provenance provenance;
  provenance.tool = "pm-candidates";
  for (const std::string& input : {options.scene, options.inventory, options.plan, options.evidence, options.state}) {
    provenance.add_input(input);
  }
  const Scene scene = load_scene(options.scene, {});
  const Inventory inventory = load_inventory(options.inventory);
  const Plan plan = load_plan(options.plan, inventory);
  Evidence evidence = load_evidence(options.evidence, inventory.row_keys());
  const State state = load_state_rows(options.state, inventory);
  const std::vector<long> gaussians = state.gaussians_per_row();
  check_evidence(options, evidence, gaussians);
  if (!scene.run.ablation.part_materials) candidate::give_one_material(evidence, inventory, state.volume_per_row());

  const candidate::Context context = candidate::make_context(inventory, evidence, plan, scene.run, gaussians, &state);
  candidate::Round round;
  // A candidate names what shapes it: a repair its base, not the screen, whose other numbers may change without it.
  Provenance candidate_provenance = provenance;
  if (options.repair.empty()) {
    round = candidate::build_initial(context, options.plan);
  } else {
    const ScreenRecord screen = load_screen(options.repair);
    if (screen.round + 1 >= scene.run.screening.rounds)
      throw invalid_field(options.repair, "/round", screen.round,
                          "a round before the last of " + std::to_string(scene.run.screening.rounds));
    const std::vector<Candidate> seen = load_seen(options, screen, inventory);
    if (!screen.repair_base.empty()) {
      const std::string base = candidate_path(options, screen.repair_base);
      if (!std::any_of(seen.begin(), seen.end(), [&](const Candidate& c) { return c.id == screen.repair_base; }))
        throw invalid_field(options.repair, "/repair/base", screen.repair_base, "the id of a screened candidate");
      provenance.add_input(base);
      candidate_provenance.add_input(base);
    }
    provenance.add_input(options.repair);
    round = candidate::build_repairs(context, screen, seen, options.plan);
  }

  write_round(options, round, candidate_provenance, provenance);
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ToolMain tool;
  tool.name = "pm-candidates";
  tool.description =
      "Executable candidates of a scene: the initial transforms of the material posterior, or repairs of a round.";
  tool.footer =
      "Example: pm-candidates --scene scene.json --inventory inventory.json --plan plan.json --evidence evidence.json "
      "--state state.h5 --out candidates\n"
      "Reads physmas/scene, inventory, plan, evidence, state and, with --repair, screen and the screened candidates; "
      "writes DIR/ID.json (physmas/candidate), DIR/roundN.json (physmas/round) and DIR/roundN.mk (one makefile line "
      "PM_ROUNDN := ids). A screen that asks for no repair gives an empty round.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "scene.json or its slice").required().type_name("FILE");
    app.add_option("--inventory", options.inventory, "inventory.json").required().type_name("FILE");
    auto plan = app.add_option("--plan", options.plan, "plan.json").type_name("FILE");
    auto evidence = app.add_option("--evidence", options.evidence, "evidence.json").type_name("FILE");
    app.add_option("--state", options.state, "state.h5").required().type_name("FILE");
    app.add_option("--out", options.out, "Folder of the candidates").required().type_name("DIR");
    auto repair = app.add_option("--repair", options.repair, "screen/roundN.json whose base is repaired for round N+1")
                      .type_name("FILE");
    app.add_option("--configuration", options.configuration,
                   "A hand-authored configuration: one candidate, `authored`, instead of those from plan and evidence")
        .type_name("FILE")
        .excludes(plan)
        .excludes(evidence)
        .excludes(repair);
  };
  tool.work = [&](const CommonOptions&) { return work(options); };
  return run_tool(argc, argv, tool);
}
