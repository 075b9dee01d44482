// Views that contradict the others.
#include "lift/agreement.h"

#include <doctest/doctest.h>

using namespace physmas;
using namespace physmas::lift;

namespace {

// Two rows in a picture of 100 pixels: the left half and the right half, or the other way round.
ViewMasks halves(const char* name, bool swapped) {
  ViewMasks view;
  view.view = name;
  for (int r = 0; r < 2; ++r) {
    Mask mask{10, 10, std::vector<uint8_t>(100, 0), 1, "test"};
    for (int p = 0; p < 100; ++p) mask.pixels[p] = (p % 10 < 5) == ((r == 0) != swapped) ? 255 : 0;
    view.rows.push_back(mask);
  }
  return view;
}

// Every view sees Gaussian i in pixel i.
std::vector<std::vector<int32_t>> all_seen(size_t views, int gaussians = 100) {
  std::vector<int32_t> pixels;
  for (int i = 0; i < gaussians; ++i) pixels.push_back(i);
  return std::vector<std::vector<int32_t>>(views, pixels);
}

}  // namespace

TEST_CASE("agreement: one view against the others does not count") {
  std::vector<ViewMasks> views = {halves("a", false), halves("b", false), halves("c", true), halves("d", false)};
  CHECK(compare_views(views, all_seen(4)).contradicted == std::vector<size_t>{2});
  CHECK(compare_views({views[0], views[1], views[3]}, all_seen(3)).contradicted.empty());
  // Halves, and two views alone: nobody knows.
  views[1] = halves("b", true);
  CHECK(compare_views(views, all_seen(4)).contradicted.empty());
  CHECK(compare_views({views[0], views[1]}, all_seen(2)).contradicted.empty());
  CHECK(compare_views({views[0], views[1]}, all_seen(2)).undecided == std::vector<std::pair<size_t, size_t>>{{0, 1}});
  CHECK(compare_views(views, all_seen(4)).undecided.size() == 4);
  views[1] = halves("b", false);
  CHECK(compare_views(views, all_seen(4)).undecided.empty());
}

TEST_CASE("agreement: what is not seen, or in no mask, says nothing") {
  const std::vector<ViewMasks> views = {halves("a", false), halves("b", false), halves("c", true), halves("d", false)};
  CHECK(compare_views(views, all_seen(4, static_cast<int>(kSharedLeast) - 1)).contradicted.empty());
  CHECK_FALSE(compare_views(views, all_seen(4, static_cast<int>(kSharedLeast))).contradicted.empty());
  auto pixels = all_seen(4);
  for (int32_t& pixel : pixels[2]) pixel = -1;
  CHECK(compare_views(views, pixels).contradicted.empty());
  std::vector<ViewMasks> none = views;
  none[2].rows[0] = none[2].rows[1] = Mask();
  CHECK(compare_views(none, all_seen(4)).contradicted.empty());
}

TEST_CASE("agreement: masks that overlap agree where one of them is the same") {
  std::vector<ViewMasks> views = {halves("a", false), halves("b", false), halves("c", false), halves("d", true)};
  for (uint8_t& pixel : views[3].rows[0].pixels) pixel = 255;
  CHECK(compare_views(views, all_seen(4)).contradicted.empty());
}
