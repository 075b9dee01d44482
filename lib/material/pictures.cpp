#include "material/pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace physmas::material {
namespace {

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

Image highlighted_sheet(const std::vector<ViewPicture>& views, const std::vector<const Mask*>& masks) {
  std::vector<ViewPicture> panels;
  for (size_t v = 0; v < views.size(); ++v) panels.push_back({views[v].view, highlighted(views[v], masks[v])});
  return view_sheet(panels);
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
