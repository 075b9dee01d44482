// pm-render: one rollout -> frames, an H.264 video and its render record; several videos -> one to compare them.
#include <fmt/format.h>

#include <filesystem>

#include "base/command_line.h"
#include "base/log.h"
#include "report/viewer.h"
#include "splat/best_video.h"
#include "splat/comparison.h"
#include "splat/rollout_video.h"
#include "splat/video_cameras.h"

namespace fs = std::filesystem;
using namespace physmas;

namespace {

using Options = splat::RolloutVideoOptions;

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
  splat::FitCamerasOptions fitting;
  std::string html;
  Command compare, best, fit_command;
  const auto ends_in = [](const std::string& ending) {
    return [ending](const std::string& path) {
      return fs::path(path).extension() == ending ? std::string() : "expected a name that ends in " + ending;
    };
  };
  const auto is_mp4 = ends_in(".mp4");
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
    splat::ExportOptions& exports = options.exports;
    also("--ply", exports.ply, "Each frame's Gaussians as a 3DGS file DIR/frame_0000.ply");
    also("--compressed-ply", exports.compressed_ply, "The same quantised, DIR/frame_0000.compressed.ply (SuperSplat)");
    also("--spz", exports.spz, "The same quantised, DIR/frame_0000.spz (version 4)");
    also("--usd", exports.usd, "All frames as ParticleField3DGaussianSplat of OpenUSD 26.03, .usdc")
        .check(ends_in(".usdc"));
    also("--npz", exports.npz, "All frames as arrays for numpy, .npz").check(ends_in(".npz"));
    Option glb =
        also("--glb", exports.glb, "One frame as glTF with KHR_gaussian_splatting, .glb").check(ends_in(".glb"));
    app.add_option("--frame", exports.glb_frame, "That frame; the last one when absent")
        .between(0, 999999)
        .needs(glb)
        .group("Also write");
    also("--html", html, "A page that plays the result in 3D in a browser, .html; one file").check(ends_in(".html"));
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
    best.add_option("--cameras", best_video.cameras, "Cameras of `pm-render fit`");
    best.add_option("--candidates", best_video.candidates, "Folder with candidate records, for render.agents: true");
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
    if (fit_command.parsed()) {
      splat::fit_cameras(fitting);
      return static_cast<int>(ExitCode::done);
    }
    require_given(options);
    splat::render_rollout(options);
    if (!html.empty())
      report::write_viewer_page(
          {options.scene, options.state, options.rollout, options.cameras, options.candidate, options.inventory, html});
    return static_cast<int>(ExitCode::done);
  };
  return run_tool(argc, argv, tool);
}
