#include "masks/view_image.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <vector>

#include "base/error.h"
#include "scene/image.h"
#include "scene/image_file.h"

namespace physmas::masks {

ViewImage load_view_image(const SceneView& view) {
  Image stored = load_image(view.image);
  if (stored.width != view.camera.width || stored.height != view.camera.height) {
    throw invalid_input({view.image, "", fmt::format("an image of {} x {} pixels", stored.width, stored.height),
                         fmt::format("{} x {}, the size of the camera of view \"{}\"", view.camera.width,
                                     view.camera.height, view.name)});
  }
  const cv::Mat raw(stored.height, stored.width, CV_8UC(stored.channels), stored.pixels.data());
  cv::Mat scaled;
  raw.convertTo(scaled, CV_32F, 1.0 / 255);
  std::vector<cv::Mat> channels;
  cv::split(scaled, channels);
  ViewImage image;
  image.view = view.name;
  if (stored.channels == 4) image.alpha = channels[3];
  const bool grey = stored.channels == 1;
  const std::vector<cv::Mat> rgb = {channels[0], channels[grey ? 0 : 1], channels[grey ? 0 : 2]};
  cv::merge(rgb, image.rgb);
  return image;
}

}  // namespace physmas::masks
