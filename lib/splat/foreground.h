// What the screen measures in a rendered frame.
#ifndef PHYSMAS_SPLAT_FOREGROUND_H
#define PHYSMAS_SPLAT_FOREGROUND_H

#include "records/render.h"
#include "scene/image.h"
#include "splat/renderer.h"

namespace physmas::splat {

// Foreground pixels are those with alpha of at least 1/2: fainter ones are the fringes of splats, whose extent says
// little about the objects. The paper leaves the threshold open.
constexpr float kForegroundAlpha = 0.5f;

// The foreground's box, and the share of its pixels whose Rec. 709 luminance (of the 8-bit values as a viewer sees
// them, over 255) is below `dark_luminance`. quantized: `image` in 8 bits, RGB.
FrameForeground measure_foreground(const RenderedImage& image, const Image& quantized, int frame,
                                   double dark_luminance);

}  // namespace physmas::splat

#endif
