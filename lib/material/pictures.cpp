#include "material/pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "splat/image_io.h"

namespace physmas::material {
namespace {

constexpr int kCellWidth = 512;    // pixels, of a panel
constexpr int kLongestCrop = 512;  // pixels
constexpr double kCropMargin = 0.1;
constexpr double kDimmed = 0.3;  // share of the own colour outside the highlight
constexpr double kDimmedTo = 200;
constexpr int kOutline = 7;  // pixels, edge of the window that widens the mask to its outline
const cv::Vec3b kMagenta(255, 0, 255);

cv::Mat pixels_of(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
}

cv::Mat inside_of(const Mask& mask) {
  return cv::Mat(mask.height, mask.width, CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
}

Image image_of(const cv::Mat& m) {
  Image image(m.cols, m.rows, 3);
  m.copyTo(pixels_of(image));
  return image;
}

Image highlighted(const ViewPicture& view, const Mask* mask) {
  const cv::Mat own = pixels_of(view.rgb);
  cv::Mat out;
  own.convertTo(out, CV_8U, kDimmed, (1 - kDimmed) * kDimmedTo);
  if (mask == nullptr || mask->area() == 0) return image_of(out);
  const cv::Mat inside = inside_of(*mask);
  cv::Mat wide;
  cv::dilate(inside, wide, cv::getStructuringElement(cv::MORPH_ELLIPSE, {kOutline, kOutline}));
  out.setTo(kMagenta, wide);
  own.copyTo(out, inside);
  return image_of(out);
}

}  // namespace

std::vector<ViewPicture> load_view_pictures(const Scene& scene) {
  std::vector<ViewPicture> pictures;
  for (const SceneView& view : scene.views) {
    const Image image = splat::load_image(view.image);
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

Image highlighted_sheet(const std::vector<ViewPicture>& views, const std::vector<const Mask*>& masks) {
  std::vector<Image> panels;
  std::vector<std::string> names;
  for (size_t v = 0; v < views.size(); ++v) {
    Image panel = highlighted(views[v], masks[v]);
    if (v > 0 && (panel.width != panels[0].width || panel.height != panels[0].height)) {
      cv::Mat scaled;
      cv::resize(pixels_of(panel), scaled, {panels[0].width, panels[0].height}, 0, 0, cv::INTER_AREA);
      panel = image_of(scaled);
    }
    panels.push_back(std::move(panel));
    names.push_back(views[v].view);
  }
  return splat::contact_sheet(panels, names, 2, kCellWidth);
}

Image masked_crop(const ViewPicture& view, const Mask& mask) {
  const cv::Mat inside = inside_of(mask);
  cv::Rect box = cv::boundingRect(inside);
  const int margin = static_cast<int>(std::ceil(kCropMargin * std::max(box.width, box.height)));
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect(0, 0, mask.width, mask.height);
  cv::Mat crop(box.size(), CV_8UC3, cv::Scalar::all(255));
  pixels_of(view.rgb)(box).copyTo(crop, inside(box));
  const double scale = double(kLongestCrop) / std::max(crop.cols, crop.rows);
  if (scale < 1) {
    cv::Mat smaller;
    cv::resize(crop, smaller, {}, scale, scale, cv::INTER_AREA);
    crop = smaller;
  }
  return image_of(crop);
}

Mask union_of(const std::vector<Mask>& masks) {
  Mask all;
  for (const Mask& mask : masks) {
    if (mask.empty()) continue;
    if (all.empty()) {
      all = mask;
      continue;
    }
    for (size_t p = 0; p < all.pixels.size(); ++p) all.pixels[p] |= mask.pixels[p];
  }
  return all;
}

}  // namespace physmas::material
