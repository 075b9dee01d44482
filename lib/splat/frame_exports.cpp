#include "splat/frame_exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/log.h"
#include "scene/gaussian_files.h"
#include "splat/turned_gaussians.h"

namespace fs = std::filesystem;

namespace physmas::splat {
namespace {

Gaussians turned(Gaussians gaussians, const std::string& from, const std::string& to) {
  if (from != to) turn_gaussians(gaussians, turn_between(from, to));
  return gaussians;
}

}  // namespace

FrameExports::FrameExports(const ExportOptions& options, const Gaussians& rest, const State& state, const Scene& scene,
                           const std::vector<int>& frames, const RolloutFrames& rollout)
    : options_(options),
      rest_(rest),
      frames_(frames),
      rollout_(rollout),
      ply_{options.ply, "frame", "ply"},
      compressed_ply_{options.compressed_ply, "frame", "compressed.ply"},
      spz_{options.spz, "frame", "spz"},
      up_(scene.run.placement.up),
      usd_up_(up_.back() == 'z' ? "z" : "y"),
      sequence_(rest) {
  if (options.glb_frame >= rollout.count())
    throw Error(ExitCode::usage,
                fmt::format("--frame: found {}, expected one below {}", options.glb_frame, rollout.count()));
  if (frames.empty()) return;
  if (!options.usd.empty()) {
    if (std::adjacent_find(frames.begin(), frames.end(), std::greater_equal<>()) != frames.end())
      throw Error(ExitCode::usage, "--frames: found frames that do not ascend, expected so for --usd");
    usd_ = std::make_unique<UsdSplats>(options.usd, usd_up_, 1 / scene.run.time.frame_dt);
  }
  if (!options.npz.empty()) npz_ = std::make_unique<NpzMotion>(options.npz, frames.size(), rest, state.gaussian_row);
}

bool FrameExports::sequence_wanted() const {
  return ply_.wanted() || compressed_ply_.wanted() || spz_.wanted() || usd_ || npz_;
}

void FrameExports::add(int frame, double time, const Deformation& deformation) {
  if (!sequence_wanted()) return;
  sequence_.advance(deformation);
  const Gaussians& all = sequence_.gaussians();
  if (ply_.wanted() || compressed_ply_.wanted() || spz_.wanted()) {
    Gaussians drawn = sequence_.drawn();
    if (ply_.wanted()) save_gaussians_ply(ply_.path(frame), drawn);
    if (compressed_ply_.wanted()) save_compressed_ply(compressed_ply_.path(frame), drawn);
    if (spz_.wanted()) save_gaussians_spz(spz_.path(frame), turned(std::move(drawn), up_, "y"));
  }
  if (npz_) npz_->add(frame, time, all);
  if (usd_) usd_->add(frame, turned(all, up_, usd_up_));
}

void FrameExports::finish() {
  for (const FrameFiles& files : {ply_, compressed_ply_, spz_}) {
    if (files.wanted()) remove_other_frames(files, frames_);
  }
  std::error_code ignored;
  if (frames_.empty()) {
    for (const std::string& old : {options_.usd, options_.npz, options_.glb}) {
      if (!old.empty()) fs::remove(old, ignored);
    }
    return;
  }
  if (usd_) usd_->commit();
  if (npz_) npz_->commit();
  if (!options_.glb.empty()) {
    const int frame = options_.glb_frame >= 0 ? options_.glb_frame : frames_.back();
    const TransportedFrame transported = rollout_.frame(frame);
    save_gaussians_glb(options_.glb, turned(deformed_gaussians(rest_, transported.deformation()), up_, "y"));
  }
  if (sequence_.hidden() > 0 && (usd_ || npz_)) {
    log_warning(fmt::format("{} Gaussians were not finite at the end: they stay where they last were in {}",
                            sequence_.hidden(), options_.usd.empty() ? options_.npz : options_.usd));
  }
}

}  // namespace physmas::splat
