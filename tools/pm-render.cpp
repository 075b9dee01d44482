// pm-render: one rollout -> frames, an H.264 video and its render record; several videos -> one to compare them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/file.h"
#include "base/log.h"
#include "records/cameras.h"
#include "records/candidate.h"
#include "records/execution.h"
#include "records/inventory.h"
#include "records/render.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/action_signs.h"
#include "splat/best_video.h"
#include "splat/comparison.h"
#include "splat/contact_sheet.h"
#include "splat/deformed_gaussians.h"
#include "splat/depth_picture.h"
#include "splat/fitted_camera.h"
#include "splat/floor_shadow.h"
#include "splat/foreground.h"
#include "splat/frame_files.h"
#include "splat/own_frame.h"
#include "splat/quantize.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"
#include "splat/row_video.h"
#include "splat/video.h"

namespace fs = std::filesystem;
using namespace physmas;

namespace {

struct Options {
  std::string scene, state, rollout, out, cameras, floor, candidate, frames, png, depth, ply, sheet, labels, inventory;
};

struct FitOptions {
  std::string scene, state, out, widen;
  std::vector<std::string> rollouts;
};

std::string execution_of(const std::string& rollout) {
  return fs::path(rollout).replace_extension(".json").string();
}

bool is_complete(const splat::RolloutFrames& rollout, const ExecutionRecord& execution, const Scene& scene) {
  return rollout.count() == scene.run.time.frames && !execution.diverged;
}

// Adds a rollout's motion. One without a video counts with its rest frame.
void add_rollout(const Scene& scene, const State& state, const Gaussians& gaussians,
                 const splat::RolloutFrames& rollout, const ExecutionRecord& execution, const std::vector<Camera>& base,
                 FittedCameras& fitted) {
  const int frames = is_complete(rollout, execution, scene) ? rollout.count() : std::min(rollout.count(), 1);
  splat::add_motion(gaussians, state, rollout, frames, base, fitted);
  fitted.candidates.push_back(execution.candidate);
}

int fit(const FitOptions& options) {
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const State state = load_state(options.state);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  FittedCameras fitted;
  if (!options.widen.empty()) fitted = load_cameras(options.widen);
  fitted.mode = scene.run.render.camera_mode();
  const std::vector<Camera> base = splat::base_cameras(scene, gaussians);
  Provenance provenance;
  provenance.tool = "pm-render";
  provenance.options.emplace_back("command", "fit");
  for (const std::string& input : {options.scene, options.state, options.widen}) {
    if (!input.empty()) provenance.add_input(input);
  }
  for (const std::string& path : options.rollouts) {
    const splat::RolloutFrames rollout(path, state);
    add_rollout(scene, state, gaussians, rollout, load_execution(execution_of(path)), base, fitted);
    provenance.add_input(path);
  }
  splat::place_cameras(gaussians, base, fitted);
  for (const Omission& omission : fitted.omitted) log_info(omission.what + ": " + omission.why);
  save_cameras(options.out, fitted, provenance);
  return 0;
}

// The foreground of frames 0 and T-1, where the video has them, as the scene's own cameras show it.
std::vector<FrameForeground> pictures_of_scene(splat::Renderer& renderer, const splat::RolloutFrames& rollout,
                                               const Scene& scene, const splat::RenderOptions& options,
                                               const std::vector<FrameForeground>& frames) {
  std::vector<FrameForeground> pictures;
  for (const int t : {0, scene.run.time.frames - 1}) {
    if (std::none_of(frames.begin(), frames.end(), [&](const FrameForeground& f) { return f.frame == t; })) continue;
    const splat::TransportedFrame frame = rollout.frame(t);
    const splat::RenderedImage& image = renderer.render(scene.output_camera(t), frame.deformation(), options);
    pictures.push_back(splat::measure_foreground(image, splat::quantize(image), t, scene.run.screening.dark_luminance));
  }
  return pictures;
}

// The floor of the video, where it has one.
std::unique_ptr<splat::FloorShadow> make_floor(const Options& options, const Scene& scene, const State& state,
                                               const Gaussians& gaussians) {
  const RunSpecification::Render& render = scene.run.render;
  if (options.floor.empty() ? !render.has_floor() : options.floor == "none") return nullptr;
  if (!scene.slice.empty() && !render.has_floor()) {
    throw invalid_input({options.scene, "/run/colliders", "a slice of a run without render.floor=shadow",
                         "scene.json, or a slice that has them"});
  }
  return std::make_unique<splat::FloorShadow>(gaussians, splat::floor_plane(scene.run, state.map, gaussians),
                                              render.background.cast<float>());
}

// Signs of what acts in the video, where they are asked for.
std::unique_ptr<splat::ActionSigns> make_signs(const Options& options, const Scene& scene, const State& state,
                                               const Gaussians& gaussians, const std::string& id) {
  if (!scene.run.render.shows_agents()) return nullptr;
  if (options.candidate.empty()) {
    throw Error(ExitCode::usage, "--candidate is required where the run specification has render.agents: true");
  }
  const Candidate candidate = load_candidate(options.candidate);
  if (candidate.id != id)
    throw invalid_input({options.candidate, "/id", candidate.id, id + ", whose rollout is rendered"});
  return std::make_unique<splat::ActionSigns>(candidate, state, gaussians, scene.run.placement.up_vector());
}

int render(const Options& options) {
  const Stopwatch total;
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  Inventory inventory;
  if (!options.labels.empty()) inventory = load_inventory(options.inventory);
  const State state = load_state(options.state, options.labels.empty() ? nullptr : &inventory);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  const splat::RolloutFrames rollout(options.rollout, state);
  const std::string execution_path = execution_of(options.rollout);
  const ExecutionRecord execution = load_execution(execution_path);
  // What the video is seen with; measurements are made in the scene's own cameras.
  const bool moved =
      !options.cameras.empty() || scene.run.render.camera_mode() != RunSpecification::Render::CameraMode::fixed;
  FittedCameras shown;
  shown.cameras = scene.output_cameras;
  if (!options.cameras.empty()) {
    shown = load_cameras(options.cameras);
    if (shown.cameras.size() != 1 && static_cast<int>(shown.cameras.size()) != scene.run.time.frames) {
      throw invalid_input({options.cameras, "/cameras", fmt::format("{} cameras", shown.cameras.size()),
                           fmt::format("one, or one per frame ({})", scene.run.time.frames)});
    }
  } else if (moved) {
    const std::vector<Camera> base = splat::base_cameras(scene, gaussians);
    add_rollout(scene, state, gaussians, rollout, execution, base, shown);
    splat::place_cameras(gaussians, base, shown);
  }

  RenderRecord record;
  record.candidate = execution.candidate;
  const int frames = scene.run.time.frames;
  const bool complete = is_complete(rollout, execution, scene);
  std::vector<int> wanted;
  if (!options.frames.empty()) {
    wanted = splat::parse_frames(options.frames, rollout.count());
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
  splat::Renderer renderer(gaussians);
  splat::RenderOptions render_options;
  render_options.background = scene.run.render.background.cast<float>();
  render_options.max_sh_degree = scene.run.render.sh_degree;
  const std::unique_ptr<splat::FloorShadow> floor = make_floor(options, scene, state, gaussians);
  const std::unique_ptr<splat::ActionSigns> signs = make_signs(options, scene, state, gaussians, record.candidate);
  std::unique_ptr<splat::VideoWriter> video;
  std::unique_ptr<splat::RowVideo> row_video;
  if (!wanted.empty()) {
    video = std::make_unique<splat::VideoWriter>(video_path, record.width, record.height, record.fps);
    if (!options.labels.empty())
      row_video = std::make_unique<splat::RowVideo>(options.labels, gaussians, state.gaussian_row,
                                                    inventory.residual_rows(), record.width, record.height, record.fps);
    if (!options.depth.empty()) record.depth_unit = splat::depth_unit(shown.cameras, state.map);
  }
  render_options.depth = record.depth_unit > 0;
  const splat::FrameFiles png = {options.png, "frame", "png"}, depth = {options.depth, "depth", "png"},
                          ply = {options.ply, "frame", "ply"};
  splat::ContactSheet sheet(wanted.size());
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
    const splat::TransportedFrame transported = rollout.frame(t);
    const splat::RenderedImage& image = renderer.render(camera, transported.deformation(), render_options);
    record.skipped_gaussians += static_cast<long>(renderer.stats().skipped);
    still += gaussians.size() - renderer.stats().reprojected;
    const Image quantized = splat::quantize(image);
    record.frames.push_back(splat::measure_foreground(image, quantized, t, scene.run.screening.dark_luminance));
    render_seconds += render_watch.seconds();
    const Stopwatch decorate_watch;
    if (floor) floor->update(transported.deformation());
    Image picture = floor ? floor->picture(image, camera) : quantized;
    if (signs) signs->draw(transported, rollout.time(t), camera, picture);
    decorate_seconds += decorate_watch.seconds();
    const Stopwatch encode_watch;
    video->write(picture);
    if (!options.sheet.empty()) sheet.add(i, t, picture);
    encode_seconds += encode_watch.seconds();
    const Stopwatch export_watch;
    if (row_video) row_video->add(camera, transported.deformation());
    if (png.wanted()) save_png(png.path(t), picture);
    if (depth.wanted()) splat::save_depth_png(depth.path(t), image, record.depth_unit);
    if (ply.wanted()) save_gaussians_ply(ply.path(t), splat::deformed_gaussians(gaussians, transported.deformation()));
    export_seconds += export_watch.seconds();
    progress.update(static_cast<long>(i) + 1);
  }
  const Stopwatch endpoint_watch;
  const std::vector<FrameForeground> measured =
      moved ? pictures_of_scene(renderer, rollout, scene, render_options, record.frames) : record.frames;
  record.endpoints = splat::measure_endpoints(renderer, gaussians, rollout, scene, render_options, measured);
  if (moved && record.endpoints.empty() && measured.size() == 2) record.endpoints = measured;
  record.own_frame = splat::measure_own_frame(renderer, gaussians, rollout, scene, state, render_options, record);
  render_seconds += endpoint_watch.seconds();
  // Pictures of an earlier run would belong to another rollout.
  for (const splat::FrameFiles& files : {png, depth, ply}) {
    if (files.wanted()) splat::remove_other_frames(files, wanted);
  }
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
  if (signs) provenance.add_input(options.candidate);
  if (!options.labels.empty()) provenance.add_input(options.inventory);
  save_render(record_path, record, provenance);
  return 0;
}

// What a call without a subcommand needs; the parser cannot know.
void require_given(const Options& options) {
  for (const auto& [flag, value] : {std::pair("--scene", &options.scene), std::pair("--state", &options.state),
                                    std::pair("--rollout", &options.rollout), std::pair("--out", &options.out)}) {
    if (value->empty()) throw Error(ExitCode::usage, fmt::format("{} is required; see pm-render --help", flag));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  splat::ComparisonOptions comparison;
  splat::BestVideoOptions best_video;
  FitOptions fitting;
  Command compare, best, fit_command;
  const auto is_mp4 = [](const std::string& path) {
    return fs::path(path).extension() == ".mp4" ? std::string() : "expected a name that ends in .mp4";
  };
  ToolMain tool;
  tool.name = "pm-render";
  tool.description = "Render a rollout's frames into an H.264 video and a render record.";
  tool.footer =
      "Example: pm-render --scene scene.json --state state.h5 --rollout rollouts/posterior.h5 --out "
      "videos/posterior.mp4\n"
      "         pm-render best --scene scene.json --state state.h5 --screen screen/round2.json --rollouts rollouts "
      "--out "
      "best.mp4\n"
      "         pm-render compare videos/posterior.mp4 videos/stiff.mp4 --out compare.mp4\n"
      "         pm-render fit --scene scene.json --state state.h5 --rollout rollouts/*.h5 --out cameras.json\n"
      "Reads physmas/scene/1, state/1, rollout/1 and the execution record beside the rollout;\n"
      "writes the video and physmas/render/1 beside it.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "Scene or its render slice (required)");
    app.add_option("--state", options.state, "State with the solver map (required)");
    app.add_option("--rollout", options.rollout, "Rollout to render (required)");
    app.add_option("--out", options.out, "Video to write, .mp4 (required); the record goes beside it").check(is_mp4);
    app.add_option("--cameras", options.cameras,
                   "Cameras of `pm-render fit` for the video; without them render.camera: fit or orbit fits this "
                   "rollout alone");
    app.add_option("--floor", options.floor, "Of the video: shadow or none; by default as the run specification says")
        .one_of({"none", "shadow"});
    app.add_option("--candidate", options.candidate, "The rollout's candidate, for render.agents: true");
    app.add_option("--frames", options.frames, "Only these frames: 0,10,20-24").group("Selection");
    const auto also = [&](const char* flag, std::string& value, const char* text) {
      return app.add_option(flag, value, text).group("Also write");
    };
    also("--sheet", options.sheet, "A contact sheet of up to eight frames, .png");
    also("--png", options.png, "Each frame as DIR/frame_0000.png");
    also("--depth", options.depth, "Each frame's depth as DIR/depth_0000.png, 16 bits");
    also("--ply", options.ply, "Each frame's Gaussians as a 3DGS file DIR/frame_0000.ply");
    Option labels = also("--labels", options.labels, "A video with the rows in colours, .mp4").check(is_mp4);
    labels.needs(also("--inventory", options.inventory, "inventory.json with the rows, for --labels"));

    fit_command = app.add_subcommand("fit", "Cameras that keep the motion of several rollouts in the picture");
    fit_command.add_option("--scene", fitting.scene, "Scene or its render slice; its render.camera is fit or orbit")
        .required();
    fit_command.add_option("--state", fitting.state, "State with the solver map").required();
    fit_command.add_option("--rollout", fitting.rollouts, "Rollouts of that state, one or more").required();
    fit_command.add_option("--widen", fitting.widen,
                           "Cameras of an earlier round, whose motion is kept in the picture");
    fit_command.add_option("--out", fitting.out, "cameras.json to write").required();

    compare = app.add_subcommand("compare", "Several videos side by side in one");
    compare.add_option("VIDEO", comparison.videos, "Videos of pm-render, two or more").required();
    compare.add_option("--out", comparison.out, "Video to write, .mp4").required().check(is_mp4);
    compare.add_option("--title", comparison.titles, "Once per video; made from their names when absent")
        .expected(1)
        .take_all();
    compare.add_option("--columns", comparison.columns, "Videos per row, 0 for about a square")
        .between(0, 64)
        .capture_default_str();
    compare.add_option("--cell-width", comparison.cell_width, "Pixels, the most that one video gets")
        .between(16, 2048)
        .capture_default_str();

    best =
        app.add_subcommand("best", "The best candidate of a run that accepted none, with the reasons in the picture");
    best.add_option("--scene", best_video.scene, "Scene or its render slice").required();
    best.add_option("--state", best_video.state, "State with the solver map").required();
    best.add_option("--screen", best_video.screen, "Screen record of the last round").required();
    best.add_option("--rollouts", best_video.rollouts, "Folder with rollouts and execution records").required();
    best.add_option("--out", best_video.out, "Video to write, .mp4").required().check(is_mp4);
  };
  tool.work = [&](const CommonOptions&) {
    if (best.parsed()) {
      const std::string id = splat::write_best_video(best_video);
      log_info(fmt::format("{}: the best candidate, which was not accepted", id));
      return static_cast<int>(ExitCode::done);
    }
    if (compare.parsed()) {
      splat::write_comparison(comparison);
      return static_cast<int>(ExitCode::done);
    }
    if (fit_command.parsed()) return fit(fitting);
    require_given(options);
    return render(options);
  };
  return run_tool(argc, argv, tool);
}
