// What the screen measures in rendered frames.
#ifndef PHYSMAS_SPLAT_FOREGROUND_H
#define PHYSMAS_SPLAT_FOREGROUND_H

#include <vector>

#include "records/render.h"
#include "records/scene.h"
#include "scene/image.h"
#include "splat/image_plane.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

// Foreground pixels are those with alpha of at least 1/2: fainter ones are the fringes of splats, whose extent says
// little about the objects. The paper leaves the threshold open.
constexpr float kForegroundAlpha = 0.5f;

// The foreground's box, and the share of its pixels whose Rec. 709 luminance (of the 8-bit values as a viewer sees
// them, over 255) is below `dark_luminance`. quantized: `image` in 8 bits, RGB.
FrameForeground measure_foreground(const RenderedImage& image, const Image& quantized, int frame,
                                   double dark_luminance);

// The foreground of `frame`, number t, in `window` of the camera's image plane; its box is in pixels of the camera.
FrameForeground measure_on_plane(Renderer& renderer, const TransportedFrame& frame, int t, const Camera& camera,
                                 const Window& window, const RenderOptions& options, double dark_luminance);

// The foreground of frames 0 and T-1 as the screen compares them: both in the first output camera, also where the video
// follows a path, and on an image plane that is not cut at the picture's edge, so that what leaves the picture still
// counts. Boxes are in pixels of that camera; their corners may lie outside the picture.
//
// pictures: the foreground of the video's frames, as measure_foreground gives it. Where frames 0 and T-1 are not among
// them, or show the same as the plane, nothing is returned; a frame whose Gaussians all end inside a picture of the
// first camera is not rendered again. The plane reaches over the splats, at most sixteen pictures beyond each edge, or
// one where that would be more than 2^24 pixels and 9 pictures. What went behind the camera is in the box of frame T-1
// (image_plane.h).
std::vector<FrameForeground> measure_endpoints(Renderer& renderer, const Gaussians& gaussians,
                                               const RolloutFrames& rollout, const Scene& scene,
                                               const RenderOptions& options,
                                               const std::vector<FrameForeground>& pictures);

}  // namespace physmas::splat

#endif
