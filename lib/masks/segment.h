// The built-in perception: masks from the views' foreground and the inventory's appearance hints.
#ifndef PHYSMAS_MASKS_SEGMENT_H
#define PHYSMAS_MASKS_SEGMENT_H

#include <vector>

#include "masks/view_image.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/provenance.h"

namespace physmas::masks {

// Foreground of one view, CV_8U 0 or 255 by pixel, and how sure it is.
struct Foreground {
  cv::Mat mask;
  double confidence = 0;    // 0..1
  const char* source = "";  // "alpha" or "background"
};

// By the image's alpha channel where it has a transparent pixel, else by the distance to the background colour (sRGB in
// 0..1) with enclosed holes filled: parts that have the background's colour are foreground when the object surrounds
// them.
Foreground find_foreground(const ViewImage& image, const Eigen::Vector3d& background);

// Distance between a pixel and a hint colour, both CIELAB (D65). Shading multiplies linear colour and so scales
// (L + 16, a, b) by one factor: chroma is compared at the hint's lightness, lightness itself counts little.
double hint_distance(const Eigen::Vector3d& pixel_lab, const Eigen::Vector3d& hint_lab);

// CIELAB of an sRGB colour in 0..1.
Eigen::Vector3d lab_of(const Eigen::Vector3d& srgb);

struct Segmentation {
  ViewMasks masks;
  std::vector<Omission> omitted;  // boundaries that were not refined because the image is large
};

// Masks of one view, in inventory order. Every foreground pixel goes to the row whose hints fit best within their
// tolerance; a row without hints takes what the others of its object leave, if it is the only one. Objects are the
// union of their rows, or what their own hints say; a single object is the whole foreground. Residual rows and rows
// that the view does not show have empty masks. Confidences: of the foreground times the mean margin between the best
// and the second row, mapped from 0..1 to 0.5..1. grabcut: refine the boundaries between rows (masks/refine.h); the
// source of a mask says whether that was done: "hints, GrabCut" or "hints".
Segmentation segment_view(const ViewImage& image, const Inventory& inventory, const Eigen::Vector3d& background,
                          bool grabcut);

}  // namespace physmas::masks

#endif
