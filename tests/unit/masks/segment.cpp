#include "masks/segment.h"

#include <doctest/doctest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "masks/mask_doubts.h"
#include "masks/refine.h"

using namespace physmas;
using namespace physmas::masks;

namespace {

constexpr int kSize = 96;
const cv::Rect kOrange(16, 16, 32, 64), kBlue(48, 16, 32, 64);
const cv::Scalar kOrangeColor(0.9, 0.5, 0.1), kBlueColor(0.1, 0.3, 0.8);

// An orange and a blue half, side by side on white, with fixed noise.
cv::Mat two_halves() {
  cv::Mat image(kSize, kSize, CV_32FC3, cv::Scalar::all(1)), noise(kSize, kSize, CV_32FC3);
  image(kOrange).setTo(kOrangeColor);
  image(kBlue).setTo(kBlueColor);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, -0.02, 0.02);
  const cv::Mat inside = cv::Mat(kSize, kSize, CV_8U, cv::Scalar(0));
  cv::Mat(inside, kOrange | kBlue).setTo(255);
  cv::add(image, noise, image, inside);
  return image;
}

// The true labels, with the boundary between them moved to the right by `shift` pixels.
cv::Mat labels_shifted(int shift) {
  cv::Mat index(kSize, kSize, CV_32S, cv::Scalar(-1));
  index(kOrange | kBlue).setTo(1);
  index(cv::Rect(kOrange.x, kOrange.y, kOrange.width + shift, kOrange.height)).setTo(0);
  return index;
}

long differences(const cv::Mat& a, const cv::Mat& b) {
  return cv::countNonZero(a != b);
}

}  // namespace

TEST_CASE("ground: GrabCut moves a boundary between parts to the edge in the image, within its band") {
  const cv::Mat image = two_halves(), truth = labels_shifted(0);
  for (const int shift : {-kRefinedBand, -1, 1, kRefinedBand}) {
    CAPTURE(shift);
    cv::Mat index = labels_shifted(shift);
    REQUIRE(differences(index, truth) == std::abs(shift) * kOrange.height);
    const std::vector<Refinement> verdicts = refine_boundaries(image, 2, index);
    CHECK(verdicts == std::vector<Refinement>{Refinement::refined, Refinement::refined});
    CHECK(differences(index, truth) == 0);
  }
  // Farther away nothing may change: the band ends before the edge. The outline stays in any case.
  cv::Mat index = labels_shifted(kRefinedBand + 4);
  const cv::Mat before = index.clone();
  refine_boundaries(image, 2, index);
  CHECK(differences(index, before) <= kRefinedBand * kOrange.height);
  CHECK(differences(index >= 0, before >= 0) == 0);
}

TEST_CASE("ground: GrabCut leaves what it cannot learn") {
  const cv::Mat image = two_halves();
  // A label of a few pixels, one that is nowhere, and one without a neighbour.
  cv::Mat index = labels_shifted(0);
  index(cv::Rect(30, 40, 6, 6)).setTo(2);
  const cv::Mat before = index.clone();
  const std::vector<Refinement> verdicts = refine_boundaries(image, 4, index);
  CHECK(verdicts[2] == Refinement::untouched);
  CHECK(verdicts[3] == Refinement::untouched);
  CHECK(cv::countNonZero((index == 2) != (before == 2)) == 0);
  cv::Mat alone(kSize, kSize, CV_32S, cv::Scalar(0));
  CHECK(refine_boundaries(image, 1, alone) == std::vector<Refinement>{Refinement::untouched});
  cv::Mat nothing(kSize, kSize, CV_32S, cv::Scalar(-1));
  refine_boundaries(image, 2, nothing);
  CHECK(cv::countNonZero(nothing != -1) == 0);
}

TEST_CASE("ground: the built-in segmenter finds parts by their hints, and its masks say whether they were refined") {
  Inventory inventory;
  inventory.objects = {{"toy", "toy", "", {}, {}}};
  const auto row = [](const char* part, const cv::Scalar& color) {
    InventoryRow r;
    r.object = "toy";
    r.part = part;
    r.name = part;
    r.hints.colors = {{color[0], color[1], color[2]}};
    return r;
  };
  inventory.rows = {row("orange", kOrangeColor), row("blue", kBlueColor)};
  const ViewImage image{"front", two_halves(), {}};
  for (const bool grabcut : {true, false}) {
    CAPTURE(grabcut);
    const Segmentation found = segment_view(image, inventory, {1, 1, 1}, grabcut);
    CHECK(found.omitted.empty());
    CHECK(found.masks.objects[0].area() == (kOrange | kBlue).area());
    CHECK(found.masks.rows[0].area() == kOrange.area());
    CHECK(found.masks.rows[1].area() == kBlue.area());
    CHECK(found.masks.rows[0].source == (grabcut ? "hints, GrabCut" : "hints"));
    CHECK(found.masks.rows[0].confidence > 0.9);
  }
}

TEST_CASE("ground: masks of nothing, of everything, and of another object are reported") {
  constexpr int kWidth = 10;
  // Columns [from, to) of ten.
  const auto columns = [](int from, int to) {
    Mask mask{kWidth, 1, std::vector<uint8_t>(kWidth, 0), 1, "test"};
    for (int x = from; x < to; ++x) mask.pixels[x] = 255;
    return mask;
  };
  Inventory inventory;
  inventory.objects.resize(2);
  inventory.objects[0].id = "left";
  inventory.objects[1].id = "right";
  for (const char* object : {"left", "right"}) {
    InventoryRow row;
    row.object = object;
    row.part = "part";
    inventory.rows.push_back(row);
  }
  const auto doubts = [&](const Mask& left, const Mask& right, const Mask& left_part, const Mask& right_part) {
    std::string all;
    for (const Omission& o : doubts_about(inventory, {"front", {left, right}, {left_part, right_part}}))
      all += o.what + ": " + o.why + "; ";
    return all;
  };
  const Mask left = columns(0, 5), right = columns(5, 10), all = columns(0, 10);
  CHECK(doubts(left, right, left, right) == "");
  CHECK(doubts(left, right, Mask(), columns(0, 0)) == "");  // a view may show nothing of a part
  CHECK(doubts(all, right, left, right) == "doubt about the mask of left in front: it covers the whole image; ");
  CHECK(doubts(left, right, right, right) == "doubt about the mask of left/part in front: most of it lies in right; ");
  CHECK(doubts(left, columns(5, 6), columns(4, 10), Mask()) ==
        "doubt about the mask of left/part in front: most of it lies outside its object; ");
  CHECK(doubts(left, left, left, left) ==
        "doubt about the masks of left and right in front: they cover the same pixels; ");
}
