// GrabCut on the boundaries between parts (Rother, Kolmogorov and Blake, "GrabCut", ACM Transactions on Graphics 23(3),
// 2004), by OpenCV.
#ifndef PHYSMAS_MASKS_REFINE_H
#define PHYSMAS_MASKS_REFINE_H

#include <opencv2/core/mat.hpp>
#include <vector>

namespace physmas::masks {

constexpr int kRefinedBand = 2;         // pixels on either side of a boundary that may change
constexpr int kLeastPixels = 200;       // of a label outside its band: a colour model has five components
constexpr long kMostPixels = 8L << 20;  // cut per image, all labels together: some 6 s of CPU time

// What became of one label. untouched: no other label is near it, or it is small. too_large: kMostPixels is used up.
enum class Refinement { untouched, refined, too_large };

// Moves the boundaries between labels to where the image has edges. For every label, colour models of it and of the
// others are learnt in the image, and the pixels of the band along its boundary to others are cut between them. A pixel
// changes only when exactly one label claims it and its own label was cut too. The outline against the background
// stays as it is.
//
// rgb: [H, W] CV_32FC3, sRGB in 0..1. index: [H, W] CV_32S, 0..labels - 1, negative where no label is; changed in
// place. [labels]. The result does not depend on the number of threads.
std::vector<Refinement> refine_boundaries(const cv::Mat& rgb, int labels, cv::Mat& index);

}  // namespace physmas::masks

#endif
