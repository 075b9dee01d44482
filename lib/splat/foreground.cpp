#include "splat/foreground.h"

#include <algorithm>
#include <array>

#include "splat/image_plane.h"
#include "splat/quantize.h"

namespace physmas::splat {
namespace {

const FrameForeground* find_frame(const std::vector<FrameForeground>& frames, int t) {
  const auto found = std::find_if(frames.begin(), frames.end(), [&](const FrameForeground& f) { return f.frame == t; });
  return found == frames.end() ? nullptr : &*found;
}

bool same_measure(const FrameForeground& a, const FrameForeground& b) {
  if (a.present != b.present || a.behind != b.behind) return false;
  return !a.present || (a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1 && a.dark_ratio == b.dark_ratio);
}

// The box with what went behind the camera in it.
void take_in(FrameForeground& foreground, const Behind& behind) {
  if (behind.count == 0) return;
  const Window& w = behind.window;
  const Window box = foreground.present ? Window{std::min(foreground.x0, w.x0), std::min(foreground.y0, w.y0),
                                                 std::max(foreground.x1, w.x1), std::max(foreground.y1, w.y1)}
                                        : w;
  foreground.present = true;
  foreground.x0 = box.x0, foreground.y0 = box.y0, foreground.x1 = box.x1, foreground.y1 = box.y1;
  foreground.behind = behind.count;
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

FrameForeground measure_on_plane(Renderer& renderer, const TransportedFrame& frame, int t, const Camera& camera,
                                 const Window& window, const RenderOptions& options, double dark_luminance) {
  FrameForeground measured;
  measured.frame = t;
  if (window.empty()) return measured;
  RenderOptions plane_options = options;
  plane_options.depth = plane_options.label = false;
  const Window plane = at_tiles(window);
  const RenderedImage& image = renderer.render(camera_of(camera, plane), frame.deformation(), plane_options);
  measured = measure_foreground(image, quantize(image), t, dark_luminance);
  measured.x0 += plane.x0, measured.x1 += plane.x0;
  measured.y0 += plane.y0, measured.y1 += plane.y0;
  return measured;
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
  bool cut_near = false;
  for (const Window& window : windows) cut_near = cut_near || too_large(window, picture);
  if (cut_near) {
    for (Window& window : windows) window = intersection(window, around_picture(camera, kNearPictures));
  }

  std::vector<FrameForeground> endpoints;
  bool same = true;
  for (size_t k = 0; k < 2; ++k) {
    const int t = frames[k];
    const FrameForeground& shown = *find_frame(pictures, t);
    FrameForeground measured = shown;
    if (!windows[k].inside(picture) || !same_view(scene.output_camera(t), camera)) {
      measured = measure_on_plane(renderer, rollout.frame(t), t, camera, windows[k], options,
                                  scene.run.screening.dark_luminance);
    }
    if (k == 1) take_in(measured, went_behind(gaussians, rollout.frame(0), rollout.frame(t), camera, near));
    same = same && same_measure(measured, shown);
    endpoints.push_back(measured);
  }
  return same ? std::vector<FrameForeground>() : endpoints;
}

}  // namespace physmas::splat
