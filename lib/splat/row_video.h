// A video that shows which Gaussian belongs to which row.
#ifndef PHYSMAS_SPLAT_ROW_VIDEO_H
#define PHYSMAS_SPLAT_ROW_VIDEO_H

#include <string>
#include <vector>

#include "splat/renderer.h"
#include "splat/video.h"

namespace physmas::splat {

// Frames of a scene with every Gaussian in its row's colour (row_colors.h), on white.
class RowVideo {
 public:
  // row: [N] index into residual; residual: [rows], grey. width, height, fps: as VideoWriter.
  RowVideo(const std::string& path, const Gaussians& gaussians, const std::vector<int32_t>& row,
           const std::vector<bool>& residual, int width, int height, double fps);
  RowVideo(const RowVideo&) = delete;
  RowVideo& operator=(const RowVideo&) = delete;
  void add(const Camera& camera, const Deformation& deformation);
  void finish() { video_.finish(); }

 private:
  Gaussians painted_;
  Renderer renderer_;
  VideoWriter video_;
};

}  // namespace physmas::splat

#endif
