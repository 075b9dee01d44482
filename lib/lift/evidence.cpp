#include "lift/evidence.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace physmas::lift {

std::vector<float> support_of(const Mask& mask) {
  if (mask.empty()) return {};
  const cv::Mat inside(mask.height, mask.width, CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
  const double confidence = mask.floored_confidence();
  const int area = cv::countNonZero(inside);
  std::vector<float> support(mask.pixels.size(), 0.0f);
  if (area == 0) return support;
  if (area == static_cast<int>(mask.pixels.size())) {
    std::fill(support.begin(), support.end(), static_cast<float>(confidence * kSupportLow));
    return support;
  }
  cv::Mat distance;
  cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  double largest = 0;
  cv::minMaxLoc(distance, nullptr, &largest);
  for (int y = 0; y < mask.height; ++y) {
    const float* d = distance.ptr<float>(y);
    for (int x = 0; x < mask.width; ++x) {
      if (d[x] <= 0) continue;
      const double share = kSupportLow + (kSupportHigh - kSupportLow) * (d[x] / largest);
      support[static_cast<size_t>(y) * mask.width + x] = static_cast<float>(confidence * share);
    }
  }
  return support;
}

}  // namespace physmas::lift
