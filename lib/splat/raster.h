// Blending the splats of one tile, front to back.
#ifndef PHYSMAS_SPLAT_RASTER_H
#define PHYSMAS_SPLAT_RASTER_H

#include <cstdint>
#include <vector>

#include "splat/binning.h"
#include "splat/lanes.h"
#include "splat/projection.h"

namespace physmas::splat {

static_assert(kLanes == kTileSize, "a row of a tile is one vector");

// Where a tile's pixels go. Pointers to whole images, row-major; depth and label may be null.
struct RasterTarget {
  int width = 0, height = 0;
  float background[3] = {0, 0, 0};
  float* rgb = nullptr;
  float* alpha = nullptr;
  float* depth = nullptr;
  int32_t* label = nullptr;
  const int32_t* gaussian_labels = nullptr;  // [N], with label only
};

// Buffers that a thread reuses from tile to tile.
class TileRaster {
 public:
  // label_count: one more than the largest label, 0 without a label image.
  explicit TileRaster(int label_count);

  // Blends splats[*begin..*end) and writes the tile at (column, row) of the tile grid.
  void draw(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
            const RasterTarget& target);

 private:
  struct alignas(64) LabelWeights {
    Lanes row[kTileSize];
  };

  template <bool kDepth, bool kLabel>
  void blend(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
             const int32_t* gaussian_labels);
  void write(int column, int row, const RasterTarget& target) const;

  alignas(64) LaneMask live_[kTileSize];
  Lanes transmittance_[kTileSize];
  Lanes color_[3][kTileSize];
  Lanes depth_[kTileSize];
  uint32_t live_rows_ = 0;
  std::vector<LabelWeights> label_weight_;  // [label]
  std::vector<int32_t> touched_;            // labels with any weight in this tile
  std::vector<char> is_touched_;            // [label]
};

}  // namespace physmas::splat

#endif
