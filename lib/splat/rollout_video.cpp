#include "splat/rollout_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "base/clock.h"
#include "base/log.h"
#include "records/execution.h"
#include "records/inventory.h"
#include "records/render.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/contact_sheet.h"
#include "splat/depth_picture.h"
#include "splat/foreground.h"
#include "splat/frame_exports.h"
#include "splat/frame_files.h"
#include "splat/own_frame.h"
#include "splat/quantize.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"
#include "splat/row_video.h"
#include "splat/video.h"
#include "splat/video_cameras.h"
#include "splat/video_pictures.h"

namespace fs = std::filesystem;

namespace physmas::splat {
namespace {

// The foreground of frames 0 and T-1, where the video has them, as the scene's own cameras show it.
std::vector<FrameForeground> pictures_of_scene(Renderer& renderer, const RolloutFrames& rollout, const Scene& scene,
                                               const RenderOptions& options,
                                               const std::vector<FrameForeground>& frames) {
  std::vector<FrameForeground> pictures;
  for (const int t : {0, scene.run.time.frames - 1}) {
    if (std::none_of(frames.begin(), frames.end(), [&](const FrameForeground& f) { return f.frame == t; })) continue;
    const TransportedFrame frame = rollout.frame(t);
    const RenderedImage& image = renderer.render(scene.output_camera(t), frame.deformation(), options);
    pictures.push_back(measure_foreground(image, quantize(image), t, scene.run.screening.dark_luminance));
  }
  return pictures;
}

}  // namespace

void render_rollout(const RolloutVideoOptions& options) {
  const Stopwatch total;
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  Inventory inventory;
  if (!options.labels.empty()) inventory = load_inventory(options.inventory);
  const State state = load_state(options.state, options.labels.empty() ? nullptr : &inventory);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  const std::string execution_path = execution_path_of(options.rollout);
  const ExecutionRecord execution = load_execution_of(options.rollout);
  require_made_from(execution_path, options.state, false);
  if (!options.cameras.empty()) {
    require_made_from(options.cameras, options.state, false);
    require_made_from(options.cameras, options.rollout, false);
  }
  const RolloutFrames rollout(options.rollout, state);
  // What the video is seen with; measurements are made in the scene's own cameras.
  const bool moved =
      !options.cameras.empty() || scene.run.render.camera_mode() != RunSpecification::Render::CameraMode::fixed;
  const FittedCameras shown = video_cameras(scene, state, gaussians, rollout, execution, options.cameras);

  RenderRecord record;
  record.candidate = execution.candidate;
  const int frames = scene.run.time.frames;
  const bool complete = is_complete(rollout, execution, scene);
  std::vector<int> wanted;
  if (!options.frames.empty()) {
    wanted = parse_frames(options.frames, rollout.count());
    record.omitted.push_back({"other frames", "--frames asks for " + options.frames});
  } else if (complete) {
    for (int t = 0; t < frames; ++t) wanted.push_back(t);
  } else {
    record.omitted.push_back({"video", fmt::format("the rollout ends after {} of {} frames ({})", rollout.count(),
                                                   frames, execution.diverged ? "diverged" : "cut")});
  }

  const std::string video_path = options.out;
  const std::string record_path = fs::path(options.out).replace_extension(".json").string();
  record.width = shown.camera(0).width;
  record.height = shown.camera(0).height;
  record.fps = 1 / scene.run.time.frame_dt;
  Renderer renderer(gaussians);
  RenderOptions render_options = video_options(scene.run.render);
  VideoPictures pictures(scene, state, gaussians,
                         {options.scene, options.rollout, options.floor, options.candidate, record.candidate});
  std::unique_ptr<VideoWriter> video;
  std::unique_ptr<RowVideo> row_video;
  if (!wanted.empty()) {
    video = std::make_unique<VideoWriter>(video_path, record.width, record.height, record.fps);
    if (!options.labels.empty())
      row_video = std::make_unique<RowVideo>(options.labels, gaussians, state.gaussian_row, inventory.residual_rows(),
                                             record.width, record.height, record.fps);
    if (!options.depth.empty()) record.depth_unit = depth_unit(shown.cameras, state.map);
  }
  render_options.depth = record.depth_unit > 0;
  const FrameFiles png = {options.png, "frame", "png"}, depth = {options.depth, "depth", "png"};
  FrameExports exports(options.exports, gaussians, state, scene, wanted, rollout);
  ContactSheet sheet(wanted.size());
  Progress progress("frame", static_cast<long>(wanted.size()));
  double render_seconds = 0, decorate_seconds = 0, encode_seconds = 0, export_seconds = 0;
  size_t still = 0;  // Gaussians, over all frames, that kept their projection
  for (size_t i = 0; i < wanted.size(); ++i) {
    const int t = wanted[i];
    const Camera& camera = shown.camera(t);
    if (camera.width != record.width || camera.height != record.height) {
      throw invalid_input({options.cameras.empty() ? options.scene : options.cameras,
                           fmt::format(options.cameras.empty() ? "/output_cameras/{}" : "/cameras/{}", t),
                           fmt::format("{}x{} pixels", camera.width, camera.height),
                           fmt::format("{}x{}, as the first one", record.width, record.height)});
    }
    const Stopwatch render_watch;
    const TransportedFrame transported = rollout.frame(t);
    const RenderedImage& image = renderer.render(camera, transported.deformation(), render_options);
    record.skipped_gaussians += static_cast<long>(renderer.stats().skipped);
    still += gaussians.size() - renderer.stats().reprojected;
    const Image quantized = quantize(image);
    record.frames.push_back(measure_foreground(image, quantized, t, scene.run.screening.dark_luminance));
    render_seconds += render_watch.seconds();
    const Stopwatch decorate_watch;
    const Image picture = pictures.picture(image, quantized, transported, rollout.time(t), camera);
    decorate_seconds += decorate_watch.seconds();
    const Stopwatch encode_watch;
    video->write(picture);
    if (!options.sheet.empty()) sheet.add(i, t, picture);
    encode_seconds += encode_watch.seconds();
    const Stopwatch export_watch;
    if (row_video) row_video->add(camera, transported.deformation());
    if (png.wanted()) save_png(png.path(t), picture);
    if (depth.wanted()) save_depth_png(depth.path(t), image, record.depth_unit);
    exports.add(t, rollout.time(t), transported.deformation());
    export_seconds += export_watch.seconds();
    progress.update(static_cast<long>(i) + 1);
  }
  const Stopwatch endpoint_watch;
  const std::vector<FrameForeground> measured =
      moved ? pictures_of_scene(renderer, rollout, scene, render_options, record.frames) : record.frames;
  record.endpoints = measure_endpoints(renderer, gaussians, rollout, scene, render_options, measured);
  if (moved && record.endpoints.empty() && measured.size() == 2) record.endpoints = measured;
  record.own_frame = measure_own_frame(renderer, gaussians, rollout, scene, state, render_options, record);
  render_seconds += endpoint_watch.seconds();
  // Pictures of an earlier run would belong to another rollout.
  for (const FrameFiles& files : {png, depth}) {
    if (files.wanted()) remove_other_frames(files, wanted);
  }
  const Stopwatch finish_watch;
  exports.finish();
  export_seconds += finish_watch.seconds();
  if (video) {
    video->finish();
    if (row_video) row_video->finish();
    if (still > 0) {
      record.omitted.push_back(
          {"projection of what stood still",
           fmt::format("{} of {} Gaussians over all frames kept covariance and colour of the frame "
                       "before: neither they nor the camera moved",
                       still, gaussians.size() * wanted.size())});
    }
    if (!options.sheet.empty()) sheet.save(options.sheet);
    record.video = fs::path(video_path).filename().string();
    record.frames_written = static_cast<int>(wanted.size());
    record.file_size = static_cast<long>(fs::file_size(video_path));
  } else {
    std::error_code ignored;
    for (const std::string& old : {video_path, options.sheet, options.labels}) {
      if (!old.empty()) fs::remove(old, ignored);
    }
    log_info(record.candidate + ": no video, " + record.omitted.back().why);
  }
  if (record.skipped_gaussians > 0) {
    log_warning(fmt::format("{}: {} Gaussians over all frames were not finite and were left out", record.candidate,
                            record.skipped_gaussians));
  }
  record.runtime = {{"seconds",
                     {{"total", total.seconds()},
                      {"render", render_seconds},
                      {"decorate", decorate_seconds},
                      {"encode", encode_seconds},
                      {"export", export_seconds}}},
                    {"peak_memory_bytes", peak_memory_bytes()}};
  Provenance provenance;
  provenance.tool = "pm-render";
  if (!options.frames.empty()) provenance.options.emplace_back("frames", options.frames);
  for (const std::string& input : {options.scene, options.state, options.rollout, execution_path})
    provenance.add_input(input);
  if (!options.cameras.empty()) provenance.add_input(options.cameras);
  if (pictures.has_signs()) provenance.add_input(options.candidate);
  if (!options.labels.empty()) provenance.add_input(options.inventory);
  if (!record.video.empty()) {
    provenance.add_output(video_path);
    if (!options.sheet.empty()) provenance.add_output(options.sheet);
  }
  save_render(record_path, record, provenance);
}

}  // namespace physmas::splat
