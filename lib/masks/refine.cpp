#include "masks/refine.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace physmas::masks {
namespace {

constexpr int kIterations = 2;
constexpr uint64_t kSeed = 1;  // of the k-means that starts the colour models
constexpr int kMargin = 8;     // pixels around the band from which the models are learnt

cv::Mat grown(const cv::Mat& mask) {
  cv::Mat out;
  const cv::Size size(2 * kRefinedBand + 1, 2 * kRefinedBand + 1);
  cv::dilate(mask, out, cv::getStructuringElement(cv::MORPH_ELLIPSE, size));
  return out;
}

// Colours and labels continued over the background from the nearest labelled pixel: a cut then has no background to
// learn from or to prefer.
void continue_outwards(cv::Mat& image, cv::Mat& index) {
  cv::Mat distance, nearest;
  cv::distanceTransform(index < 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Point> pixel_of(index.total() + 1);
  for (int y = 0; y < index.rows; ++y) {
    for (int x = 0; x < index.cols; ++x) {
      if (index.at<int>(y, x) >= 0) pixel_of[nearest.at<int>(y, x)] = {x, y};
    }
  }
  const cv::Mat labelled = index.clone();
  for (int y = 0; y < index.rows; ++y) {
    for (int x = 0; x < index.cols; ++x) {
      if (labelled.at<int>(y, x) >= 0) continue;
      const cv::Point from = pixel_of[nearest.at<int>(y, x)];
      index.at<int>(y, x) = labelled.at<int>(from);
      image.at<cv::Vec3b>(y, x) = image.at<cv::Vec3b>(from);
    }
  }
}

}  // namespace

std::vector<Refinement> refine_boundaries(const cv::Mat& rgb, int labels, cv::Mat& index) {
  std::vector<Refinement> verdicts(labels, Refinement::untouched);
  const cv::Mat labelled = index >= 0;
  if (labels < 2 || cv::countNonZero(labelled) == 0) return verdicts;
  cv::Mat image, whole = index.clone();
  rgb.convertTo(image, CV_8UC3, 255);
  continue_outwards(image, whole);
  cv::Mat claims = cv::Mat::zeros(index.size(), CV_32S), claimant = index.clone();
  long cut_pixels = 0;
  for (int k = 0; k < labels; ++k) {
    const cv::Mat own = whole == k, others = ~own;
    const cv::Mat band = grown(own) & grown(others) & labelled;
    if (cv::countNonZero(band) == 0 || cv::countNonZero(own & ~band) < kLeastPixels) continue;
    cv::Rect box = cv::boundingRect(band);
    box = cv::Rect(box.x - kMargin, box.y - kMargin, box.width + 2 * kMargin, box.height + 2 * kMargin) &
          cv::Rect({0, 0}, index.size());
    if (cut_pixels + box.area() > kMostPixels) {
      verdicts[k] = Refinement::too_large;
      continue;
    }
    cv::Mat cut(index.size(), CV_8U, cv::Scalar(cv::GC_BGD));
    cut.setTo(cv::GC_FGD, own);
    cut.setTo(cv::GC_PR_BGD, band & others);
    cut.setTo(cv::GC_PR_FGD, band & own);
    cut = cut(box).clone();
    // Both models need a pixel to start from.
    if (cv::countNonZero(cut & 1) == 0 || cv::countNonZero(cut & 1) == box.area()) continue;
    cv::Mat model_of_others, own_model;
    cv::theRNG().state = kSeed;
    cv::grabCut(image(box), cut, {}, model_of_others, own_model, kIterations, cv::GC_INIT_WITH_MASK);
    cut_pixels += box.area();
    verdicts[k] = Refinement::refined;
    cv::Mat claimed, count = claims(box), by = claimant(box);
    cv::bitwise_and(cut, 1, claimed, band(box));
    cv::add(count, 1, count, claimed);
    by.setTo(k, claimed);
  }
  cv::Mat changed = claims == 1;
  for (int k = 0; k < labels; ++k) {
    if (verdicts[k] != Refinement::refined) changed.setTo(0, index == k);
  }
  claimant.copyTo(index, changed);
  return verdicts;
}

}  // namespace physmas::masks
