// pm-eval: measure finished runs, and the solver.
#include "base/command_line.h"
#include "base/error.h"
#include "candidate/timestep.h"
#include "metrics/commands.h"
#include "studies/commands.h"
#include "tables/commands.h"

using namespace physmas;

namespace {

// The step that pm-candidates records for rows of these materials, with the fallback of the whole-object row.
double paper_step(const std::vector<mpm::Material>& materials) {
  std::vector<CandidateRow> rows;
  for (const mpm::Material& m : materials) {
    CandidateRow row;
    row.E = m.E, row.nu = m.nu, row.rho = m.rho;
    rows.push_back(row);
  }
  // time.stiff is off, so cells of any size do.
  return candidate::step_size(rows, WholeObject{}, RunSpecification::Time{}, 0.02).dt;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Subcommand> commands;
  return run_tool(
      argc, argv,
      {"pm-eval", "Measure finished runs.",
       "Example: pm-eval motion --scene scene.json --inventory inventory.json --state state.h5 --rollout rollouts/a.h5 "
       "--reference rollouts/b.h5 --out metrics.json\n"
       "         pm-eval error --scene spec/simulate.json --view spec/render.json --state state.h5 --accepted "
       "accepted.json "
       "--out error.json\n"
       "         pm-eval accuracy --out accuracy; pm-eval verification --out verification.json\n"
       "         pm-eval stability --out stability; pm-eval stiff --out stiff.json\n"
       "         pm-eval aggregate --manifest evaluation.json --upr upr.json --out tables\n"
       "         pm-eval suite --suite examples/suite.json\n"
       "Reads physmas/scene/1, inventory/1, state/1, rollout/1, metrics/1, evaluation/1, study/1, answers/1, upr/1,\n"
       "suite/1, example/1, configuration/1; writes physmas/metrics/1, study/1, upr/1, verification/1, accuracy/1,\n"
       "stability/1, stiff/1, error/1, error_study/1, labels/1, evaluation/1.",
       [&](Command app) {
         commands = {metrics::add_motion_command(app),
                     metrics::add_tracks_command(app),
                     metrics::add_flow_command(app),
                     metrics::add_tracker_command(app),
                     metrics::add_silhouettes_command(app),
                     metrics::add_clip_command(app),
                     metrics::add_study_command(app),
                     metrics::add_upr_command(app),
                     tables::add_aggregate_command(app),
                     tables::add_suite_command(app),
                     tables::add_collect_command(app),
                     metrics::add_labels_command(app),
                     studies::add_accuracy_command(app, paper_step),
                     studies::add_error_command(app),
                     studies::add_error_study_command(app),
                     studies::add_verification_command(app),
                     studies::add_stiff_command(app),
                     studies::add_stability_command(app, paper_step)};
         app.require_subcommand(1);
       },
       [&](const CommonOptions& common) {
         for (const Subcommand& command : commands) {
           if (command.command.parsed()) return command.work(common);
         }
         throw internal_error("no subcommand");
       },
       true});
}
