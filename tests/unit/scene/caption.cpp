// Text on a picture.
#include <doctest/doctest.h>

#include <algorithm>

#include "scene/image_file.h"

using namespace physmas;

namespace {

Image grey(int width, int height) {
  Image image(width, height, 3);
  for (uint8_t& v : image.pixels) v = 100;
  return image;
}

// Rows and columns from the upper left corner that the caption changed.
struct Extent {
  int width = 0, height = 0;
};
Extent changed(const Image& image) {
  Extent extent;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (*image.at(x, y) == 100) continue;
      extent.width = std::max(extent.width, x + 1);
      extent.height = std::max(extent.height, y + 1);
    }
  }
  return extent;
}

}  // namespace

TEST_CASE("scene: a caption stands in the corner, dark on light, and is wrapped at the edge") {
  Image one = grey(400, 200);
  write_caption(one, {"a few words"});
  const Extent line = changed(one);
  CHECK(line.width > 60);
  CHECK(line.width < 200);
  CHECK(line.height < 40);
  int dark = 0;
  for (int x = 0; x < line.width; ++x) dark += *one.at(x, line.height / 2) < 80;
  CHECK(dark > 0);
  CHECK(*one.at(0, 0) > 200);

  Image two = grey(400, 200);
  write_caption(two, {"a few words", "and some more"});
  CHECK(changed(two).height == line.height + 16);
  std::string words;
  for (int k = 0; k < 30; ++k) words += "word ";
  Image wrapped = grey(400, 200);
  write_caption(wrapped, {words});
  CHECK(changed(wrapped).height >= line.height + 32);
  CHECK(changed(wrapped).width <= 400);
}

TEST_CASE("scene: what does not fit into a picture is left out") {
  Image small = grey(64, 40);
  write_caption(small, {"an abcdefghijklmnopqrstuvwxyz-long word", "and another", "and another", "and another"});
  CHECK(changed(small).height <= 40);
  // The picture stays what one looks at.
  Image large = grey(300, 240);
  write_caption(large, std::vector<std::string>(20, "a reason that nothing was accepted"));
  CHECK(changed(large).height > 40);
  CHECK(changed(large).height <= 80);
  Image tiny = grey(16, 8), empty = grey(64, 64);
  write_caption(tiny, {"text"});
  write_caption(empty, {});
  CHECK(changed(tiny).height == 0);
  CHECK(changed(empty).height == 0);
}
