#include "splat/foreground.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/quantize.h"

namespace physmas::splat {
namespace {

constexpr int kFarPictures = 16, kNearPictures = 1;  // how far an image plane goes beyond the picture's edges
constexpr double kPlanePixels = 1 << 24;             // most pixels of a plane; nine pictures are always allowed

// A part of the image plane in pixels of a camera, x1 and y1 exclusive.
struct Window {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  double pixels() const { return empty() ? 0 : double(x1 - x0) * (y1 - y0); }
  bool inside(const Window& other) const {
    return empty() || (x0 >= other.x0 && y0 >= other.y0 && x1 <= other.x1 && y1 <= other.y1);
  }
};

Window intersection(const Window& a, const Window& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

// The picture and `pictures` of its size on each side.
Window around_picture(const Camera& camera, int pictures) {
  return {-pictures * camera.width, -pictures * camera.height, (pictures + 1) * camera.width,
          (pictures + 1) * camera.height};
}

// The camera whose picture is `window`.
Camera camera_of(const Camera& camera, const Window& window) {
  Camera moved = camera;
  moved.width = window.x1 - window.x0;
  moved.height = window.y1 - window.y0;
  moved.cx -= window.x0;
  moved.cy -= window.y0;
  return moved;
}

// What the splats reach of the plane, as far as kFarPictures.
Window reach_of_splats(const Gaussians& gaussians, const TransportedFrame& frame, const Camera& camera, double near) {
  const Window far = around_picture(camera, kFarPictures);
  ProjectionSetup setup;
  setup.camera = camera_of(camera, far);
  setup.near = near;
  double x0 = far.x1, y0 = far.y1, x1 = far.x0, y1 = far.y0;
  const long n = static_cast<long>(gaussians.size());
#pragma omp parallel for schedule(static) reduction(min : x0, y0) reduction(max : x1, y1)
  for (long i = 0; i < n; ++i) {
    Splat splat;
    const RestShape rest = rest_shape(gaussians, i);
    if (project_gaussian(gaussians, i, rest, frame.position(i), frame.F(i), setup, &splat) != Projection::drawn)
      continue;
    const double x = splat.x + far.x0, y = splat.y + far.y0;
    x0 = std::min(x0, x - splat.half_x), x1 = std::max(x1, x + splat.half_x);
    y0 = std::min(y0, y - splat.half_y), y1 = std::max(y1, y + splat.half_y);
  }
  if (x0 >= x1) return {};
  return {static_cast<int>(std::floor(std::max<double>(x0, far.x0))),
          static_cast<int>(std::floor(std::max<double>(y0, far.y0))),
          static_cast<int>(std::ceil(std::min<double>(x1, far.x1))),
          static_cast<int>(std::ceil(std::min<double>(y1, far.y1)))};
}

// The window with its edges at tiles of the picture, so that a pixel is blended as there.
Window at_tiles(const Window& window) {
  const auto down = [](int v) { return (v >= 0 ? v : v - kTileSize + 1) / kTileSize * kTileSize; };
  return {down(window.x0), down(window.y0), down(window.x1 + kTileSize - 1), down(window.y1 + kTileSize - 1)};
}

const FrameForeground* find_frame(const std::vector<FrameForeground>& frames, int t) {
  const auto found = std::find_if(frames.begin(), frames.end(), [&](const FrameForeground& f) { return f.frame == t; });
  return found == frames.end() ? nullptr : &*found;
}

bool same_measure(const FrameForeground& a, const FrameForeground& b) {
  if (a.present != b.present) return false;
  return !a.present || (a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1 && a.dark_ratio == b.dark_ratio);
}

bool same_view(const Camera& a, const Camera& b) {
  return ProjectionSetup{a} == ProjectionSetup{b};
}

}  // namespace

FrameForeground measure_foreground(const RenderedImage& image, const Image& quantized, int frame,
                                   double dark_luminance) {
  FrameForeground result;
  result.frame = frame;
  int x0 = image.width, y0 = image.height, x1 = 0, y1 = 0;
  long foreground = 0, dark = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.alpha[static_cast<size_t>(y) * image.width + x] < kForegroundAlpha) continue;
      ++foreground;
      const uint8_t* rgb = quantized.at(x, y);
      if ((0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255 < dark_luminance) ++dark;
      x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
      y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    }
  }
  result.present = foreground > 0;
  if (!result.present) return result;
  result.x0 = x0, result.y0 = y0, result.x1 = x1, result.y1 = y1;
  result.dark_ratio = static_cast<double>(dark) / static_cast<double>(foreground);
  return result;
}

std::vector<FrameForeground> measure_endpoints(Renderer& renderer, const Gaussians& gaussians,
                                               const RolloutFrames& rollout, const Scene& scene,
                                               const RenderOptions& options,
                                               const std::vector<FrameForeground>& pictures) {
  const Camera& camera = scene.output_camera(0);
  const Window picture = around_picture(camera, 0);
  const double near = options.near > 0 ? options.near : renderer.default_near();
  const std::array<int, 2> frames = {0, scene.run.time.frames - 1};
  std::array<Window, 2> windows;
  for (size_t k = 0; k < 2; ++k) {
    if (find_frame(pictures, frames[k]) == nullptr) return {};
    windows[k] = reach_of_splats(gaussians, rollout.frame(frames[k]), camera, near);
  }
  const double most = std::max(kPlanePixels, 9 * picture.pixels());
  if (windows[0].pixels() > most || windows[1].pixels() > most) {
    for (Window& window : windows) window = intersection(window, around_picture(camera, kNearPictures));
  }

  RenderOptions plane_options = options;
  plane_options.depth = plane_options.label = false;
  std::vector<FrameForeground> endpoints;
  bool same = true;
  for (size_t k = 0; k < 2; ++k) {
    const int t = frames[k];
    const FrameForeground& shown = *find_frame(pictures, t);
    if (windows[k].inside(picture) && same_view(scene.output_camera(t), camera)) {
      endpoints.push_back(shown);
      continue;
    }
    FrameForeground measured;
    measured.frame = t;
    if (!windows[k].empty()) {
      const TransportedFrame frame = rollout.frame(t);
      const Window plane = at_tiles(windows[k]);
      const RenderedImage& image = renderer.render(camera_of(camera, plane), frame.deformation(), plane_options);
      measured = measure_foreground(image, quantize(image), t, scene.run.screening.dark_luminance);
      measured.x0 += plane.x0, measured.x1 += plane.x0;
      measured.y0 += plane.y0, measured.y1 += plane.y0;
    }
    same = same && same_measure(measured, shown);
    endpoints.push_back(measured);
  }
  return same ? std::vector<FrameForeground>() : endpoints;
}

}  // namespace physmas::splat
