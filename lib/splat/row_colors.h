// One colour per row, for pictures and videos that show which Gaussian belongs where.
#ifndef PHYSMAS_SPLAT_ROW_COLORS_H
#define PHYSMAS_SPLAT_ROW_COLORS_H

#include <array>
#include <cstdint>
#include <vector>

#include "scene/gaussians.h"

namespace physmas::splat {

// The colour of row `row`, sRGB 0..1: one of nine, which come again after the ninth; grey for a residual row.
std::array<float, 3> row_color(int32_t row, bool residual);

// The scene with every Gaussian in its row's colour (degree 0); shading keeps a little of the scene's own lightness.
// row: [N] index into residual; residual: [rows], such rows are grey. Meant for a white background.
Gaussians painted_by_row(const Gaussians& gaussians, const std::vector<int32_t>& row,
                         const std::vector<bool>& residual);

}  // namespace physmas::splat

#endif
