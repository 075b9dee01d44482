// Masks in COCO JSON, for two views of 16 x 12 and 5 x 7 pixels.
#include "masks/coco.h"

#include "guard.h"
#include "records/json.h"

namespace {

std::vector<physmas::SceneView> two_views() {
  std::vector<physmas::SceneView> views(2);
  views[0].name = "front";
  views[0].camera.width = 16, views[0].camera.height = 12;
  views[1].name = "left";
  views[1].camera.width = 5, views[1].camera.height = 7;
  return views;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::vector<physmas::SceneView> views = two_views();
  const std::string text(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] { physmas::masks::coco_from(physmas::parse_json(text, "front.json"), "front.json", views); });
  return 0;
}
