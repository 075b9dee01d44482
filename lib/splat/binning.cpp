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

// Calls visit(tile_row, tile_column_span) for the tiles that the splat's ellipse q <= reach^2 touches.
template <typename Visit>
void for_each_tile_row(const Splat& s, int width, int height, const Visit& visit) {
  const double reach = s.reach, a = s.a, b = s.b, c = s.c;
  const double half_y = reach / c;
  const Span rows = pixel_span(s.y - half_y, s.y + half_y, height);
  if (rows.last < rows.first) return;
  // The ellipse is widest to the right at dy = -tip and to the left at dy = tip.
  const double tip = b * reach / (c * std::hypot(b, c));
  const auto half_u = [&](double dy) { return std::sqrt(std::max(0.0, reach * reach - c * c * dy * dy)); };
  for (int ty = rows.first / kTileSize; ty <= rows.last / kTileSize; ++ty) {
    const double top = std::max(ty * kTileSize, rows.first) + 0.5 - s.y;
    const double bottom = std::min(ty * kTileSize + kTileSize - 1, rows.last) + 0.5 - s.y;
    const double dy_right = std::clamp(-tip, top, bottom), dy_left = std::clamp(tip, top, bottom);
    const Span columns =
        pixel_span(s.x + (-half_u(dy_left) - b * dy_left) / a, s.x + (half_u(dy_right) - b * dy_right) / a, width);
    if (columns.first <= columns.last) visit(ty, Span{columns.first / kTileSize, columns.last / kTileSize});
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
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (int chunk = 0; chunk < kChunks; ++chunk) {
    uint32_t* counts = &chunk_count_[chunk * tiles];
    for (size_t k = order.size() * chunk / kChunks; k < order.size() * (chunk + 1) / kChunks; ++k) {
      for_each_tile_row(splats[order[k]], width, height, [&](int row, Span columns) {
        for (int column = columns.first; column <= columns.last; ++column) ++counts[row * tiles_x_ + column];
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
      for_each_tile_row(splats_[gaussian], width_, height_, [&](int row, Span columns) {
        const int begin = std::max(row * tiles_x_ + columns.first, first) - first;
        const int stop = std::min(row * tiles_x_ + columns.last + 1, end) - first;
        for (int tile = begin; tile < stop; ++tile) list_[cursor[tile]++] = gaussian;
      });
    }
  }
  return end;
}

}  // namespace physmas::splat
