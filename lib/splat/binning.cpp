#include "splat/binning.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace physmas::splat {
namespace {

struct Span {
  int first, last;  // inclusive; empty when last < first
};

// Numbers i in 0..n-1 whose pixel centre i + 0.5 lies in [low, high], with a margin for rounding.
Span pixel_span(double low, double high, int n) {
  const double margin = 0.01 + 1e-6 * (std::abs(low) + std::abs(high));
  const double first = std::ceil(low - 0.5 - margin), last = std::floor(high - 0.5 + margin);
  return {static_cast<int>(std::clamp<double>(first, 0, n)), static_cast<int>(std::clamp<double>(last, -1, n - 1))};
}

// The tiles of the splat's box; empty rows when it holds no pixel centre.
TileBox tile_box(const Splat& s, int width, int height) {
  const Span rows = pixel_span(s.y - s.half_y, s.y + s.half_y, height);
  const Span columns = pixel_span(s.x - s.half_x, s.x + s.half_x, width);
  if (rows.last < rows.first || columns.last < columns.first) return {0, -1, 0, -1};
  return {rows.first / kTileSize, rows.last / kTileSize, columns.first / kTileSize, columns.last / kTileSize};
}

// Calls visit(tile_row, first_column, last_column) for the tiles that the splat's ellipse q <= reach^2 touches.
template <typename Visit>
void for_each_tile_row(const TileBox& box, const Splat* splat, int width, int height, const Visit& visit) {
  // Most splats: in a single row or column of tiles the ellipse touches all of its box.
  if (box.first_row == box.last_row || box.first_column == box.last_column) {
    for (int row = box.first_row; row <= box.last_row; ++row) visit(row, box.first_column, box.last_column);
    return;
  }
  const Splat& s = *splat;
  const double reach = s.reach, a = s.a, b = s.b, c = s.c;
  // The ellipse is widest to the right at dy = -tip and to the left at dy = tip.
  const double tip = b * reach / (c * std::sqrt(b * b + c * c));
  const auto half_u = [&](double dy) { return std::sqrt(std::max(0.0, reach * reach - c * c * dy * dy)); };
  for (int row = box.first_row; row <= box.last_row; ++row) {
    const double top = std::max(row * kTileSize + 0.5 - s.y, static_cast<double>(-s.half_y));
    const double bottom = std::min(std::min((row + 1) * kTileSize, height) - 0.5 - s.y, static_cast<double>(s.half_y));
    // The box has a margin for rounding, in which its outermost rows may lie entirely.
    const double low = std::min(top, bottom), high = std::max(top, bottom);
    const double dy_right = std::clamp(-tip, low, high), dy_left = std::clamp(tip, low, high);
    const Span columns =
        pixel_span(s.x + (-half_u(dy_left) - b * dy_left) / a, s.x + (half_u(dy_right) - b * dy_right) / a, width);
    if (columns.first <= columns.last) visit(row, columns.first / kTileSize, columns.last / kTileSize);
  }
}

}  // namespace

void DepthOrder::sort(const uint32_t* keys, const uint8_t* shown, size_t n) {
  items_.clear();
  for (size_t i = 0; i < n; ++i) {
    if (keys[i] < kKeyNotFinite && (shown == nullptr || shown[i] != 0)) {
      items_.push_back(uint64_t{keys[i]} << 32 | i);
    }
  }
  // Radix sort of 32-bit keys, least significant digit first: stable, so that ties keep file order.
  constexpr int kBits = 11, kBuckets = 1 << kBits;
  scratch_.resize(items_.size());
  for (int shift = 32; shift < 64; shift += kBits) {
    std::array<size_t, kBuckets + 1> start{};
    for (uint64_t item : items_) ++start[((item >> shift) & (kBuckets - 1)) + 1];
    for (int k = 0; k < kBuckets; ++k) start[k + 1] += start[k];
    for (uint64_t item : items_) scratch_[start[(item >> shift) & (kBuckets - 1)]++] = item;
    items_.swap(scratch_);
  }
  order_.resize(items_.size());
  for (size_t k = 0; k < items_.size(); ++k) order_[k] = static_cast<uint32_t>(items_[k]);
  // Of millions, what sorting took is given back.
  constexpr size_t kKept = size_t{1} << 20;
  if (items_.size() <= kKept) return;
  std::vector<uint64_t>().swap(items_);
  std::vector<uint64_t>().swap(scratch_);
}

void TileBins::count(const Splat* splats, const std::vector<uint32_t>& order, int width, int height, int threads) {
  splats_ = splats;
  order_ = &order;
  width_ = width;
  height_ = height;
  tiles_x_ = (width + kTileSize - 1) / kTileSize;
  tiles_y_ = (height + kTileSize - 1) / kTileSize;
  const size_t tiles = tile_count();
  chunk_count_.assign(kChunks * tiles, 0);
  boxes_.resize(order.size());
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (int chunk = 0; chunk < kChunks; ++chunk) {
    uint32_t* counts = &chunk_count_[chunk * tiles];
    for (size_t k = order.size() * chunk / kChunks; k < order.size() * (chunk + 1) / kChunks; ++k) {
      // In depth order the splats lie all over memory.
      if (k + 12 < order.size()) __builtin_prefetch(&splats[order[k + 12]]);
      const Splat& splat = splats[order[k]];
      boxes_[k] = tile_box(splat, width, height);
      for_each_tile_row(boxes_[k], &splat, width, height, [&](int row, int first, int last) {
        for (int column = first; column <= last; ++column) ++counts[row * tiles_x_ + column];
      });
    }
  }
  pairs_ = 0;
  for (uint32_t n : chunk_count_) pairs_ += n;
}

int TileBins::fill(int first, size_t max_pairs, int threads) {
  const size_t tiles = tile_count();
  first_ = first;
  offset_.assign(1, 0);
  int end = first;
  for (; end < tile_count(); ++end) {
    size_t n = 0;
    for (int chunk = 0; chunk < kChunks; ++chunk) n += chunk_count_[chunk * tiles + end];
    if (end > first && offset_.back() + n > max_pairs) break;
    offset_.push_back(offset_.back() + n);
  }
  const size_t range = end - first;
  list_.resize(offset_.back());
  cursor_.resize(kChunks * range);
  for (size_t tile = 0; tile < range; ++tile) {
    size_t at = offset_[tile];
    for (int chunk = 0; chunk < kChunks; ++chunk) {
      cursor_[chunk * range + tile] = at;
      at += chunk_count_[chunk * tiles + first + tile];
    }
  }
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (int chunk = 0; chunk < kChunks; ++chunk) {
    size_t* cursor = &cursor_[chunk * range];
    for (size_t k = order_->size() * chunk / kChunks; k < order_->size() * (chunk + 1) / kChunks; ++k) {
      const uint32_t gaussian = (*order_)[k];
      for_each_tile_row(boxes_[k], &splats_[gaussian], width_, height_, [&](int row, int left, int right) {
        const int begin = std::max(row * tiles_x_ + left, first) - first;
        const int stop = std::min(row * tiles_x_ + right + 1, end) - first;
        for (int tile = begin; tile < stop; ++tile) list_[cursor[tile]++] = gaussian;
      });
    }
  }
  return end;
}

}  // namespace physmas::splat
