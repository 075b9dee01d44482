// The subcommands of pm-eval that read results of any method.
#ifndef PHYSMAS_EVAL_COMMANDS_H
#define PHYSMAS_EVAL_COMMANDS_H

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "base/command_line.h"
#include "eval/motion.h"
#include "records/provenance.h"

namespace physmas::eval {

struct Command {
  CLI::App* app = nullptr;  // parsed(): this is what was asked for
  std::function<int(const CommonOptions&)> work;
};

Command add_tracks_command(CLI::App& app);       // motion metrics of tracks from files
Command add_flow_command(CLI::App& app);         // motion metrics of videos by optical flow
Command add_tracker_command(CLI::App& app);      // motion metrics of videos by a tracker on a model server
Command add_silhouettes_command(CLI::App& app);  // target masks of our own rollouts
Command add_clip_command(CLI::App& app);
Command add_study_command(CLI::App& app);
Command add_upr_command(CLI::App& app);
Command add_aggregate_command(CLI::App& app);
Command add_suite_command(CLI::App& app);    // a registered benchmark against its hashes
Command add_collect_command(CLI::App& app);  // its evaluation.json

// Writes the three motion metrics as metrics.json and as lines on stdout. exchanges: with the tracker.
void report_motion(const std::string& out, const std::string& target, const Measurement& trajectory,
                   const Measurement& area, const Measurement& strain, const Provenance& provenance,
                   const std::vector<ExchangeReference>& exchanges = {});

}  // namespace physmas::eval

#endif
