// The renderer's kernels for the processor at hand.
#include "base/kernels.h"

#include "splat/raster.h"

namespace physmas::splat {

PHYSMAS_DECLARE_KERNEL(std::unique_ptr<TileRaster>, make_tile_raster, int label_count)

std::unique_ptr<TileRaster> make_tile_raster(int label_count) {
  return PHYSMAS_CHOSEN_KERNEL(make_tile_raster)(label_count);
}

}  // namespace physmas::splat
