// Blending the splats of one tile, front to back.
#ifndef PHYSMAS_SPLAT_RASTER_H
#define PHYSMAS_SPLAT_RASTER_H

#include <cstdint>
#include <memory>

#include "splat/binning.h"
#include "splat/projection.h"

namespace physmas::splat {

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

// Draws tiles, with buffers that it reuses from tile to tile: one per thread.
class TileRaster {
 public:
  virtual ~TileRaster() = default;
  // Blends splats[*begin..*end) and writes the tile at (column, row) of the tile grid.
  virtual void draw(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
                    const RasterTarget& target) = 0;
};

// label_count: one more than the largest label, 0 without a label image.
std::unique_ptr<TileRaster> make_tile_raster(int label_count);

}  // namespace physmas::splat

#endif
