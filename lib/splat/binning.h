// Which splats touch which 16 x 16 tile, front to back.
#ifndef PHYSMAS_SPLAT_BINNING_H
#define PHYSMAS_SPLAT_BINNING_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/projection.h"

namespace physmas::splat {

constexpr int kTileSize = 16;

// Depth keys that are not depths; real ones are the bits of a positive float and lie below.
constexpr uint32_t kKeyNotFinite = 0xfffffffeu, kKeyHidden = 0xffffffffu;

// Orders Gaussians by depth.
class DepthOrder {
 public:
  // keys: [n] bits of the depth, or one of the two above. shown: [n] 0 leaves a Gaussian out, or null.
  // Ties keep file order.
  void sort(const uint32_t* keys, const uint8_t* shown, size_t n);
  // Gaussians to draw, front to back.
  const std::vector<uint32_t>& front_to_back() const { return order_; }

 private:
  std::vector<uint64_t> items_, scratch_;  // key << 32 | Gaussian
  std::vector<uint32_t> order_;
};

// A rectangle of tiles, bounds included.
struct TileBox {
  int first_row, last_row, first_column, last_column;
};

// The splats of every tile, in the order in which they are given. Tiles are numbered row by row. All pairs of a large
// scene may not fit into memory at once, so they are made for one range of tiles after another.
class TileBins {
 public:
  // Counts the pairs of `splats[order[k]]` over an image of the given size. The arguments must live until the last
  // fill().
  void count(const Splat* splats, const std::vector<uint32_t>& order, int width, int height, int threads);

  int tiles_x() const { return tiles_x_; }
  int tile_count() const { return tiles_x_ * tiles_y_; }
  size_t pairs() const { return pairs_; }

  // Makes the lists of tiles first..end-1 and returns end: as many tiles as hold at most max_pairs, at least one.
  int fill(int first, size_t max_pairs, int threads);

  // The splats (Gaussian numbers) of a tile in the range that was filled last.
  const uint32_t* begin(int tile) const { return list_.data() + offset_[tile - first_]; }
  const uint32_t* end(int tile) const { return list_.data() + offset_[tile - first_ + 1]; }

 private:
  static constexpr int kChunks = 16;  // fixed, so that the lists do not depend on the number of threads

  const Splat* splats_ = nullptr;
  const std::vector<uint32_t>* order_ = nullptr;
  int width_ = 0, height_ = 0, tiles_x_ = 0, tiles_y_ = 0, first_ = 0;
  size_t pairs_ = 0;
  std::vector<TileBox> boxes_;         // [order]
  std::vector<uint32_t> chunk_count_;  // [kChunks][tiles]
  std::vector<size_t> cursor_;         // [kChunks][tiles of the range]
  std::vector<size_t> offset_;         // [tiles of the range + 1]
  std::vector<uint32_t> list_;
};

}  // namespace physmas::splat

#endif
