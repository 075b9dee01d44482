#include "ground/perception.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/error.h"
#include "ground/mask_files.h"
#include "ground/segment.h"

namespace physmas::ground {

Perception perceive(const Scene& scene, const Inventory& inventory, const std::string& mask_folder) {
  Perception perception;
  std::vector<ViewImage> images;
  for (const SceneView& view : scene.views) {
    images.push_back(load_view_image(view));
    perception.files.push_back(view.image);
  }
  if (!mask_folder.empty()) {
    perception.views = load_mask_files(mask_folder, inventory, scene.views, perception.files);
  } else {
    perception.views.resize(images.size());
    // OpenCV fills its CIELAB tables on first use, without a lock: one conversion before the threads start.
    cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar::all(0));
    cv::cvtColor(pixel, pixel, cv::COLOR_RGB2Lab);
#pragma omp parallel for schedule(dynamic)
    for (size_t v = 0; v < images.size(); ++v)
      perception.views[v] = segment_view(images[v], inventory, scene.run.render.background);
  }
  const auto shown = [&](const auto& mask_of) {
    return std::any_of(perception.views.begin(), perception.views.end(),
                       [&](const ViewMasks& view) { return !mask_of(view).empty(); });
  };
  bool anything = false;
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    const bool seen = shown([&](const ViewMasks& view) -> const Mask& { return view.objects[o]; });
    anything = anything || seen;
    if (!seen) perception.omitted.push_back({"masks of " + inventory.objects[o].id, "no view shows it"});
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].residual) continue;
    if (!shown([&](const ViewMasks& view) -> const Mask& { return view.rows[r]; })) {
      perception.omitted.push_back(
          {"masks of " + inventory.rows[r].key(), inventory.rows[r].hints.empty() && mask_folder.empty()
                                                      ? "it has no hints and its object has other rows"
                                                      : "no view shows it"});
    }
  }
  if (!anything) {
    throw invalid_input({scene.file, "/views", "views in which nothing of the inventory was found",
                         "an object in front of the background (run.render.background)",
                         "check the background colour, the hints or the masks"});
  }
  return perception;
}

}  // namespace physmas::ground
