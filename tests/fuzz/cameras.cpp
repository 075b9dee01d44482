// Cameras in JSON: transforms.json and 3DGS cameras.json, and the choice among them; nerfstudio's
// dataparser_transforms.json by its field `transform`.
#include "bundle/choose_views.h"
#include "bundle/dataparser_transform.h"
#include "guard.h"
#include "records/json.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  physmas::guard([&] {
    const physmas::Json document = physmas::parse_json(text, "input.json");
    if (document.is_object() && document.contains("transform")) {
      physmas::bundle::dataparser_transform_from(document, "input.json");
      return;
    }
    const auto views = physmas::bundle::captured_views_from(document, "input.json",
                                                            [](const std::string&) { return std::make_pair(64, 48); });
    physmas::bundle::choose_views(views, {{-1, -1, -1}, {1, 1, 1}}, "z", "input.json");
  });
  return 0;
}
