#include "masks/instances.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "masks/coco.h"
#include "masks/mask_models.h"

using namespace physmas;
using namespace physmas::masks;

namespace {

constexpr int kSize = 20;

Mask rectangle(int x0, int y0, int x1, int y1, double confidence = 1) {
  Mask mask;
  mask.width = mask.height = kSize;
  mask.confidence = confidence;
  mask.pixels.assign(kSize * kSize, 0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) mask.pixels[y * kSize + x] = 255;
  }
  return mask;
}

InventoryObject object(const std::string& id) {
  InventoryObject o;
  o.id = id;
  o.name = "cake";
  return o;
}

InventoryRow row(const std::string& object, const std::string& part) {
  InventoryRow r;
  r.object = object;
  r.part = r.name = part;
  return r;
}

// Two cakes, each an icing on a sponge; cake-1 is left in the front view and behind cake-2 as seen from the right.
struct TwoCakes {
  Inventory inventory;
  std::vector<SceneView> views{2};
  GaussianSupport support;
  FoundMasks found{2};
  Queries queries;

  TwoCakes() {
    for (const char* id : {"cake-1", "cake-2"}) {
      inventory.objects.push_back(object(id));
      inventory.rows.push_back(row(id, "sponge"));
      inventory.rows.push_back(row(id, "icing"));
    }
    views[0].name = "front";
    views[1].name = "right";
    queries = queries_of(inventory, {"front", "right"});
    support.pixel.resize(2);
    support.visible.resize(2);
    // Two Gaussians per cake, sponge and icing. Seen from the right cake-1 is farther away and higher up in the image.
    const auto add = [&](int front_x, int front_y, int right_x, int right_y) {
      support.pixel[0].push_back(front_y * kSize + front_x);
      support.pixel[1].push_back(right_y * kSize + right_x);
      for (auto& seen : support.visible) seen.push_back(1);
    };
    add(4, 12, 10, 6), add(4, 6, 10, 2), add(14, 12, 10, 16), add(14, 6, 10, 12);
    // The detector's order is not that of the inventory.
    found[0]["cake"] = {rectangle(10, 4, 18, 16), rectangle(0, 4, 8, 16)};
    found[0]["sponge"] = {rectangle(10, 10, 18, 16, 0.5), rectangle(0, 10, 8, 16, 0.9)};
    found[0]["icing"] = {rectangle(0, 4, 8, 10), rectangle(10, 4, 18, 10)};
    found[1]["cake"] = {rectangle(6, 10, 14, 20), rectangle(6, 0, 14, 8)};
    found[1]["sponge"] = {rectangle(6, 14, 14, 20), rectangle(6, 4, 14, 8)};
  }
  std::vector<ViewMasks> assign() const { return assign_instances(inventory, queries, found, views, support); }
};

}  // namespace

TEST_CASE("ground: two identical objects with identically named parts stay apart in all views") {
  const TwoCakes scene;
  const std::vector<ViewMasks> masks = scene.assign();
  // Left to right in the front view; from the right by the Gaussians that both views show.
  CHECK(masks[0].objects[0].pixels == scene.found[0].at("cake")[1].pixels);
  CHECK(masks[0].objects[1].pixels == scene.found[0].at("cake")[0].pixels);
  CHECK(masks[1].objects[0].pixels == scene.found[1].at("cake")[1].pixels);
  CHECK(masks[1].objects[1].pixels == scene.found[1].at("cake")[0].pixels);
  // Parts follow their objects: cake-1 has rows 0 and 1, cake-2 rows 2 and 3.
  CHECK(masks[0].rows[0].pixels == scene.found[0].at("sponge")[1].pixels);
  CHECK(masks[0].rows[0].confidence == doctest::Approx(0.9));
  CHECK(masks[0].rows[2].pixels == scene.found[0].at("sponge")[0].pixels);
  CHECK(masks[1].rows[0].pixels == scene.found[1].at("sponge")[1].pixels);
  CHECK(masks[1].rows[1].empty());
  CHECK(without_support(scene.inventory, masks).empty());
}

TEST_CASE("ground: equal support goes to the first query, and a mask of nothing known to nobody") {
  TwoCakes scene;
  // From the right, one mask that shows both cakes equally: the first query takes it.
  scene.found[1]["cake"] = {rectangle(6, 0, 14, 20)};
  std::vector<ViewMasks> masks = scene.assign();
  CHECK(!masks[1].objects[0].empty());
  CHECK(masks[1].objects[1].empty());
  // Beside all Gaussians: no support, no mask.
  scene.found[1]["cake"] = {rectangle(0, 0, 3, 3)};
  scene.found[1]["sponge"].clear();
  masks = scene.assign();
  CHECK(masks[1].objects[0].empty());
  CHECK(masks[1].objects[1].empty());
}

TEST_CASE("ground: detections are filtered and ordered, and nonsense is the provider's fault") {
  std::map<std::string, remote::Tensor> tensors;
  tensors["boxes"].numbers = {0, 0, 10, 10, 0, 0, 10, 9.5, 5, 5, 30, 15, 1, 1, 2, 2};
  tensors["scores"].numbers = {0.5, 0.6, 0.9, 0.2};
  tensors["phrases"].texts = {"a", "b", "c", "d"};
  const std::vector<Detection> found = detections_from(tensors, 20, 20, "test");
  // The first overlaps the stronger second by 0.95, the last is below the threshold.
  REQUIRE(found.size() == 2);
  CHECK(found[0].phrase == "c");
  CHECK(found[0].x1 == 20);
  CHECK(found[1].phrase == "b");
  tensors["scores"].numbers[1] = std::nan("");
  CHECK_THROWS_AS(detections_from(tensors, 20, 20, "test"), Error);
  tensors["scores"].numbers = {0.5, 0.6};
  CHECK_THROWS_AS(detections_from(tensors, 20, 20, "test"), Error);
}

TEST_CASE("ground: COCO's text of runs") {
  // pycocotools.mask.encode of a 5 x 5 array with rows 1..3 of columns 1..3 set.
  const std::vector<uint32_t> runs = {6, 3, 2, 3, 2, 3, 6};
  CHECK(runs_from_text("6320004") == runs);
  CHECK(runs_from_text("Xo0d0\\h0000dlP3") == std::vector<uint32_t>{1000, 20, 780, 20, 780, 20, 100000});
  CHECK(runs_from_text("6").size() == 1);
  CHECK(runs_from_text("\x7f").empty());       // beyond six bits
  CHECK(runs_from_text("ooooooooo").empty());  // a number that does not end
}
