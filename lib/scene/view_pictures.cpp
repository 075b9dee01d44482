#include "scene/view_pictures.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/error.h"
#include "scene/image_file.h"

namespace physmas {
namespace {

constexpr int kCellWidth = 512;  // pixels, of a panel of the sheet

cv::Mat pixels_of(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
}

}  // namespace

std::vector<ViewPicture> load_view_pictures(const Scene& scene) {
  std::vector<ViewPicture> pictures;
  for (const SceneView& view : scene.views) {
    const Image image = load_image(view.image);
    if (image.width != view.camera.width || image.height != view.camera.height) {
      throw invalid_input({view.image, "",
                           std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels",
                           std::to_string(view.camera.width) + " x " + std::to_string(view.camera.height) +
                               ", as its camera in " + scene.file});
    }
    ViewPicture picture{view.name, Image(image.width, image.height, 3)};
    for (size_t p = 0; p < size_t(image.width) * image.height; ++p) {
      const uint8_t* from = &image.pixels[p * image.channels];
      const double alpha = image.channels == 4 ? from[3] / 255.0 : 1;
      for (int c = 0; c < 3; ++c) {
        const double own = from[image.channels == 1 ? 0 : c];
        picture.rgb.pixels[3 * p + c] = static_cast<uint8_t>(own * alpha + 255 * (1 - alpha) + 0.5);
      }
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

Image view_sheet(const std::vector<ViewPicture>& views) {
  std::vector<Image> panels;
  std::vector<std::string> names;
  for (const ViewPicture& view : views) {
    Image panel = view.rgb;
    if (!panels.empty() && (panel.width != panels[0].width || panel.height != panels[0].height)) {
      Image scaled(panels[0].width, panels[0].height, 3);
      cv::resize(pixels_of(panel), pixels_of(scaled), {scaled.width, scaled.height}, 0, 0, cv::INTER_AREA);
      panel = std::move(scaled);
    }
    panels.push_back(std::move(panel));
    names.push_back(view.view);
  }
  return contact_sheet(panels, names, 2, kCellWidth);
}

}  // namespace physmas
