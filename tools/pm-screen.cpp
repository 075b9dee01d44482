// pm-screen: scores, gates and ranks the executed candidates, and decides the round.
#include "base/command_line.h"
#include "base/file.h"
#include "base/output.h"
#include "screen/advice.h"
#include "screen/explain.h"
#include "screen/round.h"
#include "screen/run_audit.h"
#include "screen/run_table.h"

using namespace physmas;

namespace {

struct Options : screen::RoundFiles {
  int round = -1;
  bool explain = false, advice = false;
  std::vector<std::string> table;
  std::string audit;
};

void require(const std::string& value, const char* flag) {
  if (value.empty()) throw Error(ExitCode::usage, std::string(flag) + " is required; see pm-screen --help");
}

int work(const Options& options) {
  if (options.advice) {
    print_text(screen::advice_table());
    return static_cast<int>(ExitCode::done);
  }
  if (!options.audit.empty()) {
    const screen::RunAudit audit = screen::audit_run(options.audit);
    print(screen::audit_text(options.audit, audit));
    if (audit.wrong.empty()) return static_cast<int>(ExitCode::done);
    throw invalid_input({join_path(options.audit, audit.wrong.front().file), "", audit.wrong.front().what,
                         "what was recorded", "make again what is wrong: remove it and run make"});
  }
  require(options.out, "--out");
  if (!options.table.empty()) {
    std::vector<screen::RunSummary> runs;
    for (const std::string& run : options.table) runs.push_back(screen::summarise_run(run));
    write_file(options.out, screen::run_table(runs));
    return static_cast<int>(ExitCode::done);
  }
  // Only --out: print a record that is there.
  if (options.explain && options.scene.empty()) {
    print_text(screen::explain(load_screen(options.out)));
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
  const ScreenRecord record = screen::screen_round(options, options.round);
  if (options.explain) print_text(screen::explain(record));
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
      "Compare a finished run with what was recorded: pm-screen --audit runs/demo\n"
      "What to try when a gate fails: pm-screen --advice\n"
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
    app.add_option("--audit", options.audit,
                   "Folder of a finished run: say which of its files are not what its records name by their hashes")
        .type_name("DIR");
    app.add_flag("--advice", options.advice, "Print what to try when a gate fails, a line per gate");
    app.add_flag("--explain", options.explain, "Print the round as a table; with --out alone, a record that is there");
  };
  tool.work = [&](const CommonOptions&) { return work(options); };
  return run_tool(argc, argv, tool);
}
