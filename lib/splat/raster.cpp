#include "splat/raster.h"

#include <algorithm>
#include <cmath>

namespace physmas::splat {

TileRaster::TileRaster(int label_count) : label_weight_(label_count), is_touched_(label_count, 0) {}

void TileRaster::draw(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
                      const RasterTarget& target) {
  // Pixels outside the image are never live, so that they cannot keep a full tile going.
  const int columns = std::min(kTileSize, target.width - column * kTileSize);
  const int rows = std::min(kTileSize, target.height - row * kTileSize);
  LaneMask inside{};
  for (int i = 0; i < columns; ++i) inside[i] = -1;
  live_rows_ = rows == kTileSize ? 0xffffu : (1u << rows) - 1;
  for (int r = 0; r < kTileSize; ++r) {
    live_[r] = r < rows ? inside : LaneMask{};
    transmittance_[r] = Lanes{} + 1.0f;
    for (auto& channel : color_) channel[r] = Lanes{};
    depth_[r] = Lanes{};
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
void TileRaster::blend(const Splat* splats, const uint32_t* begin, const uint32_t* end, int column, int row,
                       const int32_t* gaussian_labels) {
  const double x0 = column * kTileSize + 0.5, y0 = row * kTileSize + 0.5;
  const Lanes lane = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
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
    const Lanes step = s.a * lane;
    const float width = 15 * s.a;
    for (int r = first; r <= last; ++r) {
      const float u = u0 + s.b * static_cast<float>(r);
      if ((live_rows_ >> r & 1) == 0 || u > s.reach || u + width < -s.reach) continue;
      const float v = v0 + s.c * static_cast<float>(r);
      const Lanes us = u + step;
      const Lanes q = us * us + v * v;
      Lanes alpha = s.log2_opacity - kHalfLog2E * q;
      exp2_nonpositive(&alpha);
      alpha = alpha < max_alpha ? alpha : max_alpha;
      const LaneMask hit = (alpha >= kMinAlpha) & live_[r];
      const Lanes T = transmittance_[r];
      Lanes w = alpha * T;
      const LaneMask stop = hit & (T - w < kMinTransmittance);
      keep(hit & ~stop, &w);
      transmittance_[r] = T - w;
      for (int k = 0; k < 3; ++k) color_[k][r] += w * s.color[k];
      if constexpr (kDepth) depth_[r] += w * s.depth;
      if constexpr (kLabel) {
        if (weights != nullptr) weights->row[r] += w;
      }
      if (any(stop)) {
        live_[r] &= ~stop;
        if (!any(live_[r])) live_rows_ &= ~(1u << r);
      }
    }
  }
}

void TileRaster::write(int column, int row, const RasterTarget& target) const {
  const int columns = std::min(kTileSize, target.width - column * kTileSize);
  const int rows = std::min(kTileSize, target.height - row * kTileSize);
  for (int r = 0; r < rows; ++r) {
    const size_t first = size_t(row * kTileSize + r) * target.width + column * kTileSize;
    const Lanes T = transmittance_[r];
    for (int k = 0; k < 3; ++k) {
      const Lanes out = color_[k][r] + T * target.background[k];
      for (int i = 0; i < columns; ++i) target.rgb[3 * (first + i) + k] = out[i];
    }
    for (int i = 0; i < columns; ++i) target.alpha[first + i] = 1 - T[i];
    if (target.depth != nullptr) {
      for (int i = 0; i < columns; ++i) {
        const float alpha = 1 - T[i];
        target.depth[first + i] = alpha < kMinAlpha ? 0 : depth_[r][i] / alpha;
      }
    }
    if (target.label == nullptr) continue;
    for (int i = 0; i < columns; ++i) {
      float best = 0;
      int32_t label = -1;
      for (int32_t l : touched_) {
        const float weight = label_weight_[l].row[r][i];
        if (weight > best || (weight == best && weight > 0 && l < label)) best = weight, label = l;
      }
      target.label[first + i] = label;
    }
  }
}

}  // namespace physmas::splat
