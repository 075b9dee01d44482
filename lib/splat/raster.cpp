#include "splat/raster.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/kernels.h"
#include "splat/lanes.h"

namespace physmas::splat {

namespace {

constexpr int kParts = kTileSize / kLanes;  // registers per row of a tile
static_assert(kParts * kLanes == kTileSize, "a row of a tile is whole registers");

class LaneRaster final : public TileRaster {
 public:
  explicit LaneRaster(int label_count) : label_weight_(label_count), is_touched_(label_count, 0) {}
  void draw(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
            const RasterTarget& target) override;

 private:
  struct LabelWeights {
    Lanes part[kTileSize][kParts];
  };

  template <bool kDepth, bool kLabel>
  void blend(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
             const int32_t* gaussian_labels);
  void write(int column, int row, const RasterTarget& target) const;

  alignas(64) LaneMask live_[kTileSize][kParts];
  Lanes transmittance_[kTileSize][kParts];
  Lanes color_[3][kTileSize][kParts];
  Lanes depth_[kTileSize][kParts];
  uint32_t live_rows_ = 0;
  std::vector<LabelWeights> label_weight_;  // [label]
  std::vector<int32_t> touched_;            // labels with any weight in this tile
  std::vector<char> is_touched_;            // [label]
};

void LaneRaster::draw(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
                      const RasterTarget& target) {
  // Pixels outside the image are never live, so that they cannot keep a full tile going.
  const int columns = std::min(kTileSize, target.width - column * kTileSize);
  const int rows = std::min(kTileSize, target.height - row * kTileSize);
  LaneMask inside[kParts] = {};
  for (int i = 0; i < columns; ++i) inside[i / kLanes][i % kLanes] = -1;
  live_rows_ = rows == kTileSize ? 0xffffu : (1u << rows) - 1;
  for (int r = 0; r < kTileSize; ++r) {
    for (int p = 0; p < kParts; ++p) {
      live_[r][p] = r < rows ? inside[p] : LaneMask{};
      transmittance_[r][p] = Lanes{} + 1.0f;
      for (auto& channel : color_) channel[r][p] = Lanes{};
      depth_[r][p] = Lanes{};
    }
  }
  const bool depth = target.depth != nullptr, label = target.label != nullptr;
  if (depth && label) {
    blend<true, true>(splats, begin, end, column, row, target.gaussian_labels);
  } else if (depth) {
    blend<true, false>(splats, begin, end, column, row, nullptr);
  } else if (label) {
    blend<false, true>(splats, begin, end, column, row, target.gaussian_labels);
  } else {
    blend<false, false>(splats, begin, end, column, row, nullptr);
  }
  write(column, row, target);
  for (int32_t l : touched_) is_touched_[l] = 0;
  touched_.clear();
}

template <bool kDepth, bool kLabel>
void LaneRaster::blend(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
                       const int32_t* gaussian_labels) {
  const double x0 = column * kTileSize + 0.5, y0 = row * kTileSize + 0.5;
  Lanes lane[kParts];
  for (int i = 0; i < kTileSize; ++i) lane[i / kLanes][i % kLanes] = static_cast<float>(i);
  const Lanes max_alpha = Lanes{} + kMaxAlpha;
  constexpr float kHalfLog2E = 0.72134752f;
  for (const uint32_t* g = begin; g != end && live_rows_ != 0; ++g) {
    if (end - g > 8) __builtin_prefetch(&splats[g[8]]);
    const Splat& s = splats[*g];
    // Offsets from the mean are taken in double: the mean may lie far outside the tile.
    const double dx = x0 - s.x, dy = y0 - s.y;
    const float u0 = static_cast<float>(s.a * dx + s.b * dy), v0 = static_cast<float>(s.c * dy);
    const float inverse_c = 1 / s.c;
    const int first = static_cast<int>(std::ceil(std::clamp((-s.reach - v0) * inverse_c, 0.0f, 16.0f)));
    const int last = static_cast<int>(std::floor(std::clamp((s.reach - v0) * inverse_c, -1.0f, 15.0f)));
    if (first > last) continue;
    LabelWeights* weights = nullptr;
    if constexpr (kLabel) {
      const int32_t label = gaussian_labels[*g];
      if (label >= 0) {
        weights = &label_weight_[label];
        if (!is_touched_[label]) {
          is_touched_[label] = 1;
          touched_.push_back(label);
          *weights = LabelWeights{};
        }
      }
    }
    Lanes step[kParts];
    for (int p = 0; p < kParts; ++p) step[p] = s.a * lane[p];
    const float width = (kLanes - 1) * s.a;
    for (int r = first; r <= last; ++r) {
      if ((live_rows_ >> r & 1) == 0) continue;
      const float u = u0 + s.b * static_cast<float>(r), v = v0 + s.c * static_cast<float>(r);
      bool stopped = false;
      for (int p = 0; p < kParts; ++p) {
        const float u_first = u + step[p][0];
        if (u_first > s.reach || u_first + width < -s.reach) continue;
        const Lanes us = u + step[p];
        const Lanes q = us * us + v * v;
        Lanes alpha = s.log2_opacity - kHalfLog2E * q;
        exp2_nonpositive(&alpha);
        alpha = alpha < max_alpha ? alpha : max_alpha;
        const LaneMask hit = (alpha >= kMinAlpha) & live_[r][p];
        const Lanes T = transmittance_[r][p];
        Lanes w = alpha * T;
        const LaneMask stop = hit & (T - w < kMinTransmittance);
        keep(hit & ~stop, &w);
        transmittance_[r][p] = T - w;
        for (int k = 0; k < 3; ++k) color_[k][r][p] += w * s.color[k];
        if constexpr (kDepth) depth_[r][p] += w * s.depth;
        if constexpr (kLabel) {
          if (weights != nullptr) weights->part[r][p] += w;
        }
        if (any(stop)) {
          live_[r][p] &= ~stop;
          stopped = true;
        }
      }
      if (stopped && std::none_of(live_[r], live_[r] + kParts, any)) live_rows_ &= ~(1u << r);
    }
  }
}

void LaneRaster::write(int column, int row, const RasterTarget& target) const {
  const int columns = std::min(kTileSize, target.width - column * kTileSize);
  const int rows = std::min(kTileSize, target.height - row * kTileSize);
  for (int r = 0; r < rows; ++r) {
    const size_t first = size_t(row * kTileSize + r) * target.width + column * kTileSize;
    alignas(64) float T[kTileSize], sum[kTileSize];
    std::memcpy(T, transmittance_[r], sizeof(T));
    for (int k = 0; k < 3; ++k) {
      for (int p = 0; p < kParts; ++p) {
        const Lanes out = color_[k][r][p] + transmittance_[r][p] * target.background[k];
        std::memcpy(sum + p * kLanes, &out, sizeof(out));
      }
      for (int i = 0; i < columns; ++i) target.rgb[3 * (first + i) + k] = sum[i];
    }
    for (int i = 0; i < columns; ++i) target.alpha[first + i] = 1 - T[i];
    if (target.depth != nullptr) {
      std::memcpy(sum, depth_[r], sizeof(sum));
      for (int i = 0; i < columns; ++i) {
        const float alpha = 1 - T[i];
        target.depth[first + i] = alpha < kMinAlpha ? 0 : sum[i] / alpha;
      }
    }
    if (target.label == nullptr) continue;
    for (int i = 0; i < columns; ++i) {
      float best = 0;
      int32_t label = -1;
      for (int32_t l : touched_) {
        const float weight = label_weight_[l].part[r][i / kLanes][i % kLanes];
        if (weight > best || (weight == best && weight > 0 && l < label)) best = weight, label = l;
      }
      target.label[first + i] = label;
    }
  }
}

}  // namespace

namespace PHYSMAS_KERNELS {

std::unique_ptr<TileRaster> make_tile_raster(int label_count) {
  return std::make_unique<LaneRaster>(label_count);
}

}  // namespace PHYSMAS_KERNELS

}  // namespace physmas::splat
