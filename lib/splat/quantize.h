// 8-bit views of rendered images.
#ifndef PHYSMAS_SPLAT_QUANTIZE_H
#define PHYSMAS_SPLAT_QUANTIZE_H

#include "scene/image.h"
#include "splat/renderer.h"

namespace physmas::splat {

// RGB, cut to 0..1 and rounded to the nearest of 256 levels.
Image quantize(const RenderedImage& image);

// RGBA with straight alpha, for images that were rendered over a black background.
Image quantize_with_alpha(const RenderedImage& image);

}  // namespace physmas::splat

#endif
