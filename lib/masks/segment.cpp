#include "masks/segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "masks/refine.h"

namespace physmas::masks {
namespace {

// Largest channel difference (of 1) up to which a pixel is background.
constexpr double kBackgroundTolerance = 0.05;
constexpr float kAlphaInside = 0.5f;
// Weight of lightness in the hint distance, and how far shading may have scaled a colour.
constexpr double kLightnessWeight = 0.3;
constexpr double kShadingRange = 2.0;
// A row that has only a region fits its pixels this well, as a share of the tolerance: a fitting colour wins.
constexpr float kRegionScore = 0.5f;
constexpr float kNoFit = 2.0f;      // score of a pixel outside a row's region
constexpr int kSmoothing = 5;       // pixels, edge of the Gaussian window on the scores
constexpr int kReach = 24;          // pixels that a row's label may spread into foreground that fits no row
constexpr int kSmallestPiece = 12;  // pixels; smaller connected pieces of a row are noise
constexpr int kUnassigned = -1;
constexpr const char* kHintsSource = "hints";
constexpr const char* kRefinedSource = "hints, GrabCut";

// Whether the hints say anything about this view.
bool shown_by(const AppearanceHints& hints, const std::string& view) {
  return !hints.empty() && (hints.regions.empty() || hints.regions.count(view) > 0);
}

cv::Mat region_mask(const AppearanceHints& hints, const std::string& view, cv::Size size) {
  cv::Mat mask(size, CV_8U, cv::Scalar(hints.regions.empty() ? 255 : 0));
  const auto found = hints.regions.find(view);
  if (found == hints.regions.end()) return mask;
  // Sixteenths of a pixel, shifted so that the centre of pixel i is i as OpenCV draws it.
  constexpr int kShift = 4;
  for (const std::vector<Eigen::Vector2d>& polygon : found->second) {
    std::vector<cv::Point> points;
    for (const Eigen::Vector2d& p : polygon) {
      points.emplace_back(static_cast<int>(std::lround((p.x() * size.width - 0.5) * (1 << kShift))),
                          static_cast<int>(std::lround((p.y() * size.height - 0.5) * (1 << kShift))));
    }
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255), cv::LINE_8, kShift);
  }
  return mask;
}

// Hint distance over tolerance, [H, W] CV_32F: at most 1 fits.
cv::Mat score_image(const cv::Mat& lab, const AppearanceHints& hints, const std::string& view) {
  cv::Mat score(lab.size(), CV_32F, cv::Scalar(hints.colors.empty() ? kRegionScore : kNoFit));
  std::vector<Eigen::Vector3d> colors;
  for (const Eigen::Vector3d& color : hints.colors) colors.push_back(lab_of(color));
  for (int y = 0; y < lab.rows && !colors.empty(); ++y) {
    const cv::Vec3f* pixel = lab.ptr<cv::Vec3f>(y);
    float* out = score.ptr<float>(y);
    for (int x = 0; x < lab.cols; ++x) {
      const Eigen::Vector3d p(pixel[x][0], pixel[x][1], pixel[x][2]);
      for (const Eigen::Vector3d& color : colors)
        out[x] = std::min(out[x], static_cast<float>(hint_distance(p, color) / hints.tolerance));
    }
  }
  score.setTo(kNoFit, region_mask(hints, view, lab.size()) == 0);
  return score;
}

// Smooths inside the foreground only, so that the background's colour does not leak in.
cv::Mat smooth(const cv::Mat& score, const cv::Mat& weight) {
  cv::Mat sum, total;
  cv::GaussianBlur(score.mul(weight), sum, {kSmoothing, kSmoothing}, 0);
  cv::GaussianBlur(weight, total, {kSmoothing, kSmoothing}, 0);
  return sum / (total + 1e-6f);
}

// Index of the best score per pixel, [H, W] CV_32S; kUnassigned outside `inside` and where nothing fits.
struct Winners {
  cv::Mat index;
  cv::Mat margin;  // CV_32F, second best (at most 1) minus best, 0..1
};

Winners best_scores(const std::vector<cv::Mat>& scores, const cv::Mat& inside) {
  Winners w{cv::Mat(inside.size(), CV_32S, cv::Scalar(kUnassigned)), cv::Mat::zeros(inside.size(), CV_32F)};
  for (int y = 0; y < inside.rows; ++y) {
    for (int x = 0; x < inside.cols; ++x) {
      if (inside.at<uint8_t>(y, x) == 0) continue;
      float best = std::numeric_limits<float>::infinity(), second = 1;
      int winner = kUnassigned;
      for (size_t k = 0; k < scores.size(); ++k) {
        const float s = scores[k].at<float>(y, x);
        if (s < best) {
          if (winner != kUnassigned) second = std::min(second, best);
          best = s;
          winner = static_cast<int>(k);
        } else {
          second = std::min(second, s);
        }
      }
      if (best > 1) continue;
      w.index.at<int>(y, x) = winner;
      w.margin.at<float>(y, x) = second - best;
    }
  }
  return w;
}

// Small connected pieces lose their label.
void drop_specks(cv::Mat& index, int labels) {
  for (int k = 0; k < labels; ++k) {
    cv::Mat pieces, stats, centroids;
    const int count = cv::connectedComponentsWithStats(index == k, pieces, stats, centroids, 8, CV_32S);
    for (int c = 1; c < count; ++c) {
      if (stats.at<int>(c, cv::CC_STAT_AREA) < kSmallestPiece) index.setTo(kUnassigned, pieces == c);
    }
  }
}

// Unassigned foreground takes the label of the nearest labelled pixel within reach: edges that the background shines
// through, specks, highlights.
void spread_labels(cv::Mat& index, const cv::Mat& foreground) {
  const cv::Mat unlabelled = index == kUnassigned;
  if (cv::countNonZero(unlabelled) == 0 || cv::countNonZero(unlabelled) == static_cast<int>(index.total())) return;
  cv::Mat distance, nearest;
  cv::distanceTransform(unlabelled, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<int> label_of(index.total() + 1, kUnassigned);
  for (int y = 0; y < index.rows; ++y) {
    for (int x = 0; x < index.cols; ++x) {
      if (unlabelled.at<uint8_t>(y, x) == 0) label_of[nearest.at<int>(y, x)] = index.at<int>(y, x);
    }
  }
  for (int y = 0; y < index.rows; ++y) {
    for (int x = 0; x < index.cols; ++x) {
      if (unlabelled.at<uint8_t>(y, x) != 0 && foreground.at<uint8_t>(y, x) != 0 && distance.at<float>(y, x) <= kReach)
        index.at<int>(y, x) = label_of[nearest.at<int>(y, x)];
    }
  }
}

Mask mask_from(const cv::Mat& inside, double confidence, const std::string& source) {
  Mask mask;
  if (cv::countNonZero(inside) == 0) return mask;
  mask.width = inside.cols;
  mask.height = inside.rows;
  mask.confidence = confidence;
  mask.source = source;
  const cv::Mat whole = inside.isContinuous() ? inside : inside.clone();
  mask.pixels.assign(whole.data, whole.data + whole.total());
  return mask;
}

// What the rows' hints make of one view's foreground.
struct Partition {
  std::vector<int> rows;                // inventory row of each label
  std::vector<cv::Mat> masks;           // by label
  std::vector<double> margins;          // by label, mean over the mask, 0..1
  std::vector<Refinement> refinements;  // by label; empty without GrabCut
};

Partition partition_foreground(const ViewImage& image, const cv::Mat& foreground, const Inventory& inventory,
                               bool grabcut) {
  Partition partition;
  cv::Mat lab;
  cv::cvtColor(image.rgb, lab, cv::COLOR_RGB2Lab);
  cv::Mat weight;
  foreground.convertTo(weight, CV_32F, 1.0 / 255);
  std::vector<cv::Mat> scores;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (!shown_by(inventory.rows[r].hints, image.view)) continue;
    partition.rows.push_back(static_cast<int>(r));
    scores.push_back(smooth(score_image(lab, inventory.rows[r].hints, image.view), weight));
  }
  // The outermost pixels mix with the background: they follow their neighbours.
  cv::Mat inner;
  cv::erode(foreground, inner, cv::Mat(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  Winners winners = best_scores(scores, inner);
  drop_specks(winners.index, static_cast<int>(scores.size()));
  spread_labels(winners.index, foreground);
  if (grabcut) partition.refinements = refine_boundaries(image.rgb, static_cast<int>(scores.size()), winners.index);
  for (size_t k = 0; k < partition.rows.size(); ++k) {
    partition.masks.push_back(winners.index == static_cast<int>(k));
    partition.margins.push_back(cv::mean(winners.margin, partition.masks.back())[0]);
  }
  return partition;
}

}  // namespace

Eigen::Vector3d lab_of(const Eigen::Vector3d& srgb) {
  cv::Mat pixel(1, 1, CV_32FC3, cv::Scalar(srgb.x(), srgb.y(), srgb.z())), lab;
  cv::cvtColor(pixel, lab, cv::COLOR_RGB2Lab);
  const cv::Vec3f v = lab.at<cv::Vec3f>(0, 0);
  return {v[0], v[1], v[2]};
}

double hint_distance(const Eigen::Vector3d& pixel, const Eigen::Vector3d& hint) {
  const double shading = std::clamp((hint[0] + 16) / (pixel[0] + 16), 1 / kShadingRange, kShadingRange);
  const double l = kLightnessWeight * (pixel[0] - hint[0]);
  return std::sqrt(l * l + std::pow(shading * pixel[1] - hint[1], 2) + std::pow(shading * pixel[2] - hint[2], 2));
}

Foreground find_foreground(const ViewImage& image, const Eigen::Vector3d& background) {
  Foreground foreground;
  double least = 1;
  if (!image.alpha.empty()) cv::minMaxLoc(image.alpha, &least);
  if (least < kAlphaInside) {
    foreground.mask = image.alpha > kAlphaInside;
    foreground.confidence = cv::mean(image.alpha, foreground.mask)[0];
    foreground.source = "alpha";
    return foreground;
  }
  cv::Mat difference;
  cv::absdiff(image.rgb, cv::Scalar(background.x(), background.y(), background.z()), difference);
  std::vector<cv::Mat> channels;
  cv::split(difference, channels);
  const cv::Mat largest = cv::max(channels[0], cv::max(channels[1], channels[2]));
  // Background is what connects to the image's border; enclosed pieces belong to the object.
  cv::Mat empty, pieces;
  cv::copyMakeBorder(largest <= kBackgroundTolerance, empty, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::connectedComponents(empty, pieces, 4, CV_32S);
  const cv::Mat outside = pieces == pieces.at<int>(0, 0);
  foreground.mask = ~outside(cv::Rect(1, 1, image.rgb.cols, image.rgb.rows)).clone();
  foreground.confidence = 1;
  foreground.source = "background";
  return foreground;
}

Segmentation segment_view(const ViewImage& image, const Inventory& inventory, const Eigen::Vector3d& background,
                          bool grabcut) {
  const Foreground foreground = find_foreground(image, background);
  Segmentation segmentation;
  ViewMasks& view = segmentation.masks;
  view.view = image.view;
  view.objects.resize(inventory.objects.size());
  view.rows.resize(inventory.rows.size());
  const Partition partition = partition_foreground(image, foreground.mask, inventory, grabcut);
  cv::Mat rest = foreground.mask.clone();
  for (size_t k = 0; k < partition.rows.size(); ++k) {
    const double confidence = foreground.confidence * (0.5 + 0.5 * partition.margins[k]);
    const Refinement refinement = grabcut ? partition.refinements[k] : Refinement::untouched;
    view.rows[partition.rows[k]] =
        mask_from(partition.masks[k], confidence, refinement == Refinement::refined ? kRefinedSource : kHintsSource);
    if (refinement == Refinement::too_large) {
      segmentation.omitted.push_back(
          {fmt::format("GrabCut of {} in {}", inventory.rows[partition.rows[k]].key(), image.view),
           fmt::format("the view has more than {} pixels to cut", kMostPixels)});
    }
    rest.setTo(0, partition.masks[k]);
  }
  const bool single = inventory.objects.size() == 1;
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    const InventoryObject& object = inventory.objects[o];
    std::vector<int> unhinted;
    cv::Mat united = cv::Mat::zeros(foreground.mask.size(), CV_8U);
    double weighted = 0, area = 0;
    const char* source = kHintsSource;
    for (size_t r = 0; r < inventory.rows.size(); ++r) {
      const InventoryRow& row = inventory.rows[r];
      if (row.object != object.id || row.residual) continue;
      if (row.hints.empty()) unhinted.push_back(static_cast<int>(r));
      const auto k = std::find(partition.rows.begin(), partition.rows.end(), static_cast<int>(r));
      if (k == partition.rows.end() || view.rows[r].empty()) continue;
      united |= partition.masks[k - partition.rows.begin()];
      if (view.rows[r].source == kRefinedSource) source = kRefinedSource;
      const double pixels = static_cast<double>(view.rows[r].area());
      weighted += view.rows[r].confidence * pixels;
      area += pixels;
    }
    cv::Mat own = united;
    double confidence = area > 0 ? weighted / area : foreground.confidence;
    if (shown_by(object.hints, image.view)) {
      cv::Mat lab;
      cv::cvtColor(image.rgb, lab, cv::COLOR_RGB2Lab);
      own = (score_image(lab, object.hints, image.view) <= 1) & foreground.mask;
      own |= united;
    } else if (single) {
      own = foreground.mask;
      confidence = foreground.confidence;
      source = foreground.source;
    }
    if (unhinted.size() == 1 && (single || !object.hints.empty())) {
      view.rows[unhinted[0]] = mask_from(rest & own, foreground.confidence, foreground.source);
      own |= rest & own;
    }
    view.objects[o] = mask_from(own, confidence, source);
  }
  return segmentation;
}

}  // namespace physmas::masks
