// The subcommands of pm-eval.
#ifndef PHYSMAS_EVAL_COMMANDS_H
#define PHYSMAS_EVAL_COMMANDS_H

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "base/command_line.h"
#include "eval/motion.h"
#include "eval/stability.h"
#include "records/provenance.h"

namespace physmas::eval {

struct Command {
  CLI::App* app = nullptr;  // parsed(): this is what was asked for
  std::function<int(const CommonOptions&)> work;
};

// Our own runs.
Command add_motion_command(CLI::App& app);
Command add_silhouettes_command(CLI::App& app);  // target masks
Command add_labels_command(CLI::App& app);       // of a synthesised scene

// Anyone's results.
Command add_tracks_command(CLI::App& app);   // motion metrics of tracks from files
Command add_flow_command(CLI::App& app);     // motion metrics of videos by optical flow
Command add_tracker_command(CLI::App& app);  // motion metrics of videos by a tracker on a model server
Command add_clip_command(CLI::App& app);
Command add_study_command(CLI::App& app);
Command add_upr_command(CLI::App& app);
Command add_aggregate_command(CLI::App& app);
Command add_suite_command(CLI::App& app);    // a registered benchmark against its hashes
Command add_collect_command(CLI::App& app);  // its evaluation.json

// The solver itself.
Command add_accuracy_command(CLI::App& app, const PaperStep& paper_step);
Command add_stability_command(CLI::App& app, const PaperStep& paper_step);
Command add_verification_command(CLI::App& app);

// Writes the three motion metrics as metrics.json and as lines on stdout. exchanges: with the tracker.
void report_motion(const std::string& out, const std::string& target, const Measurement& trajectory,
                   const Measurement& area, const Measurement& strain, const Provenance& provenance,
                   const std::vector<ExchangeReference>& exchanges = {});

}  // namespace physmas::eval

#endif
