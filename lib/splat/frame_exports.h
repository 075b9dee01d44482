// A rollout's Gaussians in files of other programs.
#ifndef PHYSMAS_SPLAT_FRAME_EXPORTS_H
#define PHYSMAS_SPLAT_FRAME_EXPORTS_H

#include <memory>
#include <string>
#include <vector>

#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussians.h"
#include "splat/deformed_gaussians.h"
#include "splat/frame_files.h"
#include "splat/npz_motion.h"
#include "splat/rollout_frames.h"
#include "splat/usd_splats.h"

namespace physmas::splat {

// Folders for a file per frame, files for all frames; empty ones are not wanted.
struct ExportOptions {
  std::string ply, compressed_ply, spz;  // folders
  std::string usd, npz;                  // files
  std::string glb;                       // file of one frame
  int glb_frame = -1;                    // -1: the last one
};

// PLY files are in the scene's axes; .spz, .glb and .usdc have y or z up, as their formats ask, and the scene is turned
// where it has another axis up.
class FrameExports {
 public:
  // rest: the scene's Gaussians. frames: those that will be added, in that order, none when the rollout is cut short.
  // All three must outlive this. Errors: exit code 2 for frames that do not ascend in a .usdc file or a --frame beyond
  // the rollout.
  FrameExports(const ExportOptions& options, const Gaussians& rest, const State& state, const Scene& scene,
               const std::vector<int>& frames, const RolloutFrames& rollout);
  void add(int frame, double time, const Deformation& deformation);
  // Ends the files of several frames; removes what an earlier rollout left.
  void finish();

 private:
  bool sequence_wanted() const;

  const ExportOptions options_;
  const Gaussians& rest_;
  const std::vector<int>& frames_;
  const RolloutFrames& rollout_;
  FrameFiles ply_, compressed_ply_, spz_;
  std::string up_, usd_up_;
  DeformedSequence sequence_;
  std::unique_ptr<UsdSplats> usd_;
  std::unique_ptr<NpzMotion> npz_;
};

}  // namespace physmas::splat

#endif
