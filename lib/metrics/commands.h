// The subcommands of pm-eval that measure results.
#ifndef PHYSMAS_METRICS_COMMANDS_H
#define PHYSMAS_METRICS_COMMANDS_H

#include <string>
#include <vector>

#include "base/command_line.h"
#include "metrics/motion.h"
#include "records/provenance.h"

namespace physmas::metrics {

// Our own runs.
Subcommand add_motion_command(Command app);
Subcommand add_silhouettes_command(Command app);  // target masks
Subcommand add_labels_command(Command app);       // of a synthesised scene

// Anyone's results.
Subcommand add_tracks_command(Command app);   // motion metrics of tracks from files
Subcommand add_flow_command(Command app);     // motion metrics of videos by optical flow
Subcommand add_tracker_command(Command app);  // motion metrics of videos by a tracker on a model server
Subcommand add_clip_command(Command app);
Subcommand add_study_command(Command app);  // a blinded page for respondents
Subcommand add_upr_command(Command app);    // user preference rates from their answers

// Writes the three motion metrics as metrics.json and as lines on stdout. exchanges: with the tracker.
void report_motion(const std::string& out, const std::string& target, const Measurement& trajectory,
                   const Measurement& area, const Measurement& strain, const Provenance& provenance,
                   const std::vector<ExchangeReference>& exchanges = {});

}  // namespace physmas::metrics

#endif
