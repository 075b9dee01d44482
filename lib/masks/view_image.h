// The four views as the built-in perception reads them.
#ifndef PHYSMAS_MASKS_VIEW_IMAGE_H
#define PHYSMAS_MASKS_VIEW_IMAGE_H

#include <opencv2/core/mat.hpp>
#include <string>

#include "records/scene.h"

namespace physmas::masks {

struct ViewImage {
  std::string view;
  cv::Mat rgb;    // [H, W] CV_32FC3, sRGB in 0..1, channel order R G B
  cv::Mat alpha;  // [H, W] CV_32F in 0..1; empty when the file has no alpha channel
};

// Errors (exit code 3) as load_image, and when the image's size is not its camera's.
ViewImage load_view_image(const SceneView& view);

}  // namespace physmas::masks

#endif
