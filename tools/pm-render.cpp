// pm-render: one rollout -> frames, an H.264 video and its render record.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/file.h"
#include "base/log.h"
#include "records/execution.h"
#include "records/render.h"
#include "records/rollout.h"
#include "records/state.h"
#include "scene/gaussian_files.h"
#include "scene/scene.h"
#include "splat/foreground.h"
#include "splat/image_io.h"
#include "splat/renderer.h"
#include "splat/transport.h"
#include "splat/video.h"

namespace fs = std::filesystem;
using namespace physmas;

namespace {

struct Options {
  std::string scene, state, rollout, out, frames, png, ply, sheet;
};

// "0,10,20-24" -> frame numbers in the given order; every one must be below `count`.
std::vector<int> parse_frames(const std::string& list, int count) {
  std::vector<int> frames;
  size_t at = 0;
  const auto bad = [&] {
    return Error(ExitCode::usage,
                 fmt::format("--frames: found \"{}\", expected frame numbers and ranges below {}, such as 0,10,20-24",
                             list, count));
  };
  const auto number = [&]() -> int {
    size_t end = at;
    while (end < list.size() && std::isdigit(static_cast<unsigned char>(list[end])) != 0) ++end;
    if (end == at || end - at > 6) throw bad();
    const int value = std::stoi(list.substr(at, end - at));
    at = end;
    if (value >= count) throw bad();
    return value;
  };
  while (at < list.size()) {
    const int first = number();
    int last = first;
    if (at < list.size() && list[at] == '-') {
      ++at;
      last = number();
    }
    for (int t = first; t <= last; ++t) frames.push_back(t);
    if (at < list.size() && list[at++] != ',') throw bad();
  }
  if (frames.empty()) throw bad();
  return frames;
}

// Collects some of the frames for a contact sheet: at most eight, evenly spaced, the first and the last among them.
class ContactSheet {
 public:
  explicit ContactSheet(size_t frames) : count_(std::min<size_t>(frames, 8)), frames_(frames) {}
  void add(size_t i, int frame, const Image& image) {
    const size_t k = pictures_.size();
    if (k == count_ || i != (count_ == 1 ? 0 : k * (frames_ - 1) / (count_ - 1))) return;
    pictures_.push_back(image);
    captions_.push_back("frame " + std::to_string(frame));
  }
  void save(const std::string& path) const {
    splat::save_png(path, splat::contact_sheet(pictures_, captions_, 4, 360));
  }

 private:
  size_t count_, frames_;
  std::vector<Image> pictures_;
  std::vector<std::string> captions_;
};

int render(const Options& options, const CommonOptions&) {
  if (!options.ply.empty())
    throw Error(ExitCode::usage, "--ply: writing a PLY per frame is not built yet; use --png for frames");
  const Stopwatch total;
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const State state = load_state(options.state);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  const RolloutReader rollout(options.rollout, gaussians.size());
  const std::string execution_path = fs::path(options.rollout).replace_extension(".json").string();
  const ExecutionRecord execution = load_execution(execution_path);

  RenderRecord record;
  record.candidate = execution.candidate;
  const int frames = scene.run.time.frames;
  const bool complete = rollout.frame_count() == frames && !execution.diverged;
  std::vector<int> wanted;
  if (!options.frames.empty()) {
    wanted = parse_frames(options.frames, rollout.frame_count());
    record.omitted.push_back({"other frames", "--frames asks for " + options.frames});
  } else if (complete) {
    for (int t = 0; t < frames; ++t) wanted.push_back(t);
  } else {
    record.omitted.push_back({"video", fmt::format("the rollout ends after {} of {} frames ({})", rollout.frame_count(),
                                                   frames, execution.diverged ? "diverged" : "cut")});
  }

  const std::string video_path = options.out;
  const std::string record_path = fs::path(options.out).replace_extension(".json").string();
  record.width = scene.output_camera(0).width;
  record.height = scene.output_camera(0).height;
  record.fps = 1 / scene.run.time.frame_dt;
  splat::Renderer renderer(gaussians);
  splat::RenderOptions render_options;
  render_options.background = scene.run.render.background.cast<float>();
  render_options.max_sh_degree = scene.run.render.sh_degree;
  std::unique_ptr<splat::VideoWriter> video;
  if (!wanted.empty())
    video = std::make_unique<splat::VideoWriter>(video_path, record.width, record.height, record.fps);
  ContactSheet sheet(wanted.size());
  Progress progress("frame", static_cast<long>(wanted.size()));
  double render_seconds = 0, encode_seconds = 0;
  for (size_t i = 0; i < wanted.size(); ++i) {
    const int t = wanted[i];
    const Camera& camera = scene.output_camera(t);
    if (camera.width != record.width || camera.height != record.height) {
      throw invalid_input({options.scene, fmt::format("/output_cameras/{}", t),
                           fmt::format("{}x{} pixels", camera.width, camera.height),
                           fmt::format("{}x{}, as the first output camera", record.width, record.height)});
    }
    const Stopwatch render_watch;
    const splat::TransportedFrame transported(rollout.frame(t), state.map);
    const splat::RenderedImage& image = renderer.render(camera, transported.deformation(), render_options);
    record.skipped_gaussians += static_cast<long>(renderer.stats().skipped);
    const Image quantized = splat::quantize(image);
    record.frames.push_back(splat::measure_foreground(image, quantized, t, scene.run.screening.dark_luminance));
    render_seconds += render_watch.seconds();
    const Stopwatch encode_watch;
    video->write(quantized);
    if (!options.png.empty())
      splat::save_png((fs::path(options.png) / fmt::format("frame_{:04d}.png", t)).string(), quantized);
    if (!options.sheet.empty()) sheet.add(i, t, quantized);
    encode_seconds += encode_watch.seconds();
    progress.update(static_cast<long>(i) + 1);
  }
  if (video) {
    video->finish();
    if (!options.sheet.empty()) sheet.save(options.sheet);
    record.video = fs::path(video_path).filename().string();
    record.frames_written = static_cast<int>(wanted.size());
    record.file_size = static_cast<long>(fs::file_size(video_path));
  } else {
    // Pictures of an earlier run would belong to another rollout.
    std::error_code ignored;
    fs::remove(video_path, ignored);
    if (!options.sheet.empty()) fs::remove(options.sheet, ignored);
    log_info(record.candidate + ": no video, " + record.omitted.back().why);
  }
  if (record.skipped_gaussians > 0) {
    log_warning(fmt::format("{}: {} Gaussians over all frames were not finite and were left out", record.candidate,
                            record.skipped_gaussians));
  }
  record.runtime = {{"seconds", {{"total", total.seconds()}, {"render", render_seconds}, {"encode", encode_seconds}}},
                    {"peak_memory_bytes", peak_memory_bytes()}};
  Provenance provenance;
  provenance.tool = "pm-render";
  if (!options.frames.empty()) provenance.options.emplace_back("frames", options.frames);
  for (const std::string& input : {options.scene, options.state, options.rollout, execution_path})
    provenance.add_input(input);
  save_render(record_path, record, provenance);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  return run_tool(
      argc, argv,
      {"pm-render", "Render a rollout's frames into an H.264 video and a render record.",
       "Example: pm-render --scene scene.json --state state.h5 --rollout rollouts/posterior.h5 --out "
       "videos/posterior.mp4\n"
       "Reads physmas/scene/1, state/1, rollout/1 and the execution record beside the rollout;\n"
       "writes the video and physmas/render/1 beside it.",
       [&](CLI::App& app) {
         app.add_option("--scene", options.scene, "Scene or its render slice")->required();
         app.add_option("--state", options.state, "State with the solver map")->required();
         app.add_option("--rollout", options.rollout, "Rollout to render")->required();
         app.add_option("--out", options.out, "Video to write, .mp4; the record goes beside it")
             ->required()
             ->check([](const std::string& path) {
               return fs::path(path).extension() == ".mp4" ? std::string() : "--out: expected a name that ends in .mp4";
             });
         app.add_option("--frames", options.frames, "Only these frames: 0,10,20-24")->group("Selection");
         app.add_option("--sheet", options.sheet, "Also write a contact sheet of up to eight frames, .png")
             ->group("Selection");
         app.add_option("--png", options.png, "Also write each frame as DIR/frame_0000.png")->group("Selection");
         app.add_option("--ply", options.ply, "Also write each frame as a 3DGS PLY (not built yet)")
             ->group("Selection");
       },
       [&](const CommonOptions& common) { return render(options, common); }});
}
