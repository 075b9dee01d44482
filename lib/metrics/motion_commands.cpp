// pm-eval tracks, flow and tracker: motion metrics of anyone's results.
#include <fmt/format.h>

#include <memory>

#include "base/error.h"
#include "base/output.h"
#include "metrics/commands.h"
#include "metrics/video_tracks.h"
#include "records/metrics.h"

namespace physmas::metrics {
namespace {

struct PairOptions {
  std::string reference, measured, reference_masks, masks, target = "scene", out;
  int width = 0, height = 0;
};

void add_pair_options(Command command, PairOptions& options, bool masks_required) {
  Option masks = command.add_option("--reference-masks", options.reference_masks,
                                    "Folder of the reference's target masks, one PNG per frame");
  if (masks_required) masks.required();
  command.add_option("--masks", options.masks, "Folder of the target masks of what is measured").needs(masks);
  command.add_option("--target", options.target, "What is measured: an object id, for pm-eval aggregate");
  command.add_option("--out", options.out, "Metrics to write").required();
}

// Points count inside their masks, where there are any; without both there is no area to compare.
int measure(const PairOptions& options, const char* source, Tracks reference, Tracks measured,
            const std::vector<ExchangeReference>& exchanges = {}) {
  Measurement area;
  area.reason = "no target masks";
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "motion"}, {"tracks", source}, {"target", options.target}};
  provenance.add_input(options.reference);
  provenance.add_input(options.measured);
  if (options.masks.empty()) {
    provenance.options.emplace_back("masks", options.reference_masks.empty() ? "none" : "reference only");
    if (!options.reference_masks.empty())
      restrict_to_masks(reference, load_masks(options.reference_masks), options.reference_masks);
  } else {
    const std::vector<Image> expected = load_masks(options.reference_masks), found = load_masks(options.masks);
    restrict_to_masks(reference, expected, options.reference_masks);
    restrict_to_masks(measured, found, options.masks);
    area = area_log_rmse(mask_areas(expected), mask_areas(found));
  }
  report_motion(options.out, options.target, trajectory_nrmse(reference, measured), area,
                strain_rmse(reference, measured), provenance, exchanges);
  return 0;
}

struct TrackerOptions : PairOptions {
  std::string tracker;
  remote::RemoteOptions remote;
};

int tracker(const TrackerOptions& options) {
  const std::vector<QueryPixel> queries = query_pixels(load_masks(options.reference_masks).front());
  const auto backend = remote::open_backend(options.tracker, "--tracker", "", options.remote);
  remote::InferenceClient client(*backend, "tracker", remote::tensor_form(options.remote.tensors));
  client.require_model({"frames", "queries"}, {"tracks", "visibility"});
  Tracks reference = track_by_server(client, "reference", options.reference, queries);
  Tracks measured = track_by_server(client, "measured", options.measured, queries);
  return measure(options, "tracker", std::move(reference), std::move(measured), backend->exchanges());
}

}  // namespace

void report_motion(const std::string& out, const std::string& target, const Measurement& trajectory,
                   const Measurement& area, const Measurement& strain, const Provenance& provenance,
                   const std::vector<ExchangeReference>& exchanges) {
  std::vector<MetricEntry> metrics;
  const auto add = [&](const char* name, const Measurement& m) {
    metrics.push_back({name, m.valid, m.value, m.samples, m.reason});
    print("{:<18} {}\n", name,
          m.valid ? fmt::format("{:.4f} ({} samples)", m.value, m.samples) : "invalid: " + m.reason);
  };
  add("trajectory_nrmse", trajectory);
  add("area_log_rmse", area);
  add("strain_rmse", strain);
  save_metrics(out, target, metrics, provenance, exchanges);
}

Subcommand add_tracks_command(Command app) {
  const auto options = std::make_shared<PairOptions>();
  Command command = app.add_subcommand("tracks", "Motion metrics of point tracks from files (.npz or JSON)");
  command.add_option("--reference", options->reference, "Tracks of the reference: tracks [1,T,N,2], visibility [1,T,N]")
      .required();
  command.add_option("--tracks", options->measured, "Tracks of the video to measure, from the same queries").required();
  command.add_option("--width", options->width, "Pixels of the videos").required().between(1, 16384);
  command.add_option("--height", options->height, "Pixels of the videos").required().between(1, 16384);
  add_pair_options(command, *options, false);
  return {command, [options](const CommonOptions&) {
            return measure(*options, "file", load_tracks(options->reference, options->width, options->height),
                           load_tracks(options->measured, options->width, options->height));
          }};
}

Subcommand add_flow_command(Command app) {
  const auto options = std::make_shared<PairOptions>();
  Command command = app.add_subcommand("flow", "Motion metrics of two videos, tracked by optical flow");
  command.add_option("--reference", options->reference, "Video of the reference").required();
  command.add_option("--video", options->measured, "Video to measure").required();
  add_pair_options(command, *options, true);
  return {command, [options](const CommonOptions&) {
            const std::vector<QueryPixel> queries = query_pixels(load_masks(options->reference_masks).front());
            return measure(*options, "optical flow", track_by_flow(options->reference, queries),
                           track_by_flow(options->measured, queries));
          }};
}

Subcommand add_tracker_command(Command app) {
  const auto options = std::make_shared<TrackerOptions>();
  Command command = app.add_subcommand("tracker", "Motion metrics of two videos, tracked by a model server");
  command.add_option("--reference", options->reference, "Video of the reference").required();
  command.add_option("--video", options->measured, "Video to measure").required();
  command
      .add_option("--tracker", options->tracker,
                  "Model behind Open Inference Protocol v2: frames and queries to tracks and visibility")
      .required();
  add_pair_options(command, *options, true);
  remote::add_remote_options(command, options->remote);
  remote::add_tensor_options(command, options->remote);
  return {command, [options](const CommonOptions&) { return tracker(*options); }};
}

}  // namespace physmas::metrics
