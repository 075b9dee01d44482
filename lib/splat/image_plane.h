// The image plane beyond the picture's edges.
#ifndef PHYSMAS_SPLAT_IMAGE_PLANE_H
#define PHYSMAS_SPLAT_IMAGE_PLANE_H

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

constexpr int kFarPictures = 16, kNearPictures = 1;  // how far an image plane goes beyond the picture's edges

// A part of the image plane in pixels of a camera, x1 and y1 exclusive.
struct Window {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  double pixels() const { return empty() ? 0 : double(x1 - x0) * (y1 - y0); }
  bool inside(const Window& other) const {
    return empty() || (x0 >= other.x0 && y0 >= other.y0 && x1 <= other.x1 && y1 <= other.y1);
  }
};

Window intersection(const Window& a, const Window& b);

// The picture and `pictures` of its size on each side.
Window around_picture(const Camera& camera, int pictures);

// Whether a plane has more pixels than are rendered: 2^24, nine pictures being always allowed.
bool too_large(const Window& window, const Window& picture);

// The camera whose picture is `window`.
Camera camera_of(const Camera& camera, const Window& window);

// The window with its edges at tiles of the picture, so that a pixel is blended as there.
Window at_tiles(const Window& window);

// What the splats reach of the plane, as far as kFarPictures. near: scene units.
Window reach_of_splats(const Gaussians& gaussians, const TransportedFrame& frame, const Camera& camera, double near);

// What was before the camera in `first` and is behind its near plane in `last`. It left the view where its line of
// sight through the near plane is: there it counts, as far as kFarPictures. Gaussians of an opacity from 1/2 count, and
// from one in a thousand of them on: a stray one says nothing about the objects.
struct Behind {
  long count = 0;
  Window window;  // not empty where count > 0
};
Behind went_behind(const Gaussians& gaussians, const TransportedFrame& first, const TransportedFrame& last,
                   const Camera& camera, double near);

}  // namespace physmas::splat

#endif
