#include "ground/view_image.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace physmas::ground {

cv::Mat decode_image(const std::string& path) {
  const std::string bytes = read_file(path);
  cv::Mat image;
  try {
    if (!bytes.empty()) {
      const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
      image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    }
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw invalid_input({path, "", fmt::format("{} bytes that are no image", bytes.size()), "a PNG or JPEG image"});
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    throw invalid_input({path, "", "an image of another depth", "8 or 16 bits per channel"});
  return image;
}

ViewImage load_view_image(const SceneView& view) {
  const cv::Mat raw = decode_image(view.image);
  if (raw.cols != view.camera.width || raw.rows != view.camera.height) {
    throw invalid_input({view.image, "", fmt::format("an image of {} x {} pixels", raw.cols, raw.rows),
                         fmt::format("{} x {}, the size of the camera of view \"{}\"", view.camera.width,
                                     view.camera.height, view.name)});
  }
  cv::Mat scaled;
  raw.convertTo(scaled, CV_32F, raw.depth() == CV_8U ? 1.0 / 255 : 1.0 / 65535);
  std::vector<cv::Mat> channels;
  cv::split(scaled, channels);
  ViewImage image;
  image.view = view.name;
  // One or two channels are grey, with or without alpha.
  const bool grey = channels.size() < 3;
  if (channels.size() == 2 || channels.size() == 4) image.alpha = channels.back();
  const std::vector<cv::Mat> rgb = {channels[grey ? 0 : 2], channels[grey ? 0 : 1], channels[0]};
  cv::merge(rgb, image.rgb);
  return image;
}

}  // namespace physmas::ground
