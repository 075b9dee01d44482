#include "masks/perception.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "base/error.h"
#include "base/words.h"
#include "masks/mask_doubts.h"
#include "masks/mask_files.h"
#include "masks/segment.h"
#include "records/reference.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"

namespace physmas::masks {
namespace {

std::vector<Segmentation> segment_views(const std::vector<ViewImage>& images, const Inventory& inventory,
                                        const RunSpecification& run) {
  std::vector<Segmentation> views(images.size());
  // OpenCV fills its CIELAB tables on first use, without a lock: one conversion before the threads start.
  cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar::all(0));
  cv::cvtColor(pixel, pixel, cv::COLOR_RGB2Lab);
#pragma omp parallel for schedule(dynamic)
  for (size_t v = 0; v < images.size(); ++v)
    views[v] = segment_view(images[v], inventory, run.render.background, run.segmentation.grabcut);
  return views;
}

// What the models find, asked text by text and remembered, so that a second attempt asks for new texts only.
class ModelSearch {
 public:
  ModelSearch(const Scene& scene, const std::vector<ViewPicture>& pictures, MaskModels& models)
      : scene_(scene), models_(models), found_(pictures.size()), asked_(pictures.size(), 0) {
    for (const ViewPicture& picture : pictures) pngs_.push_back(encode_png(picture.rgb));
    support_ = support_in_views(load_gaussians(scene.gaussians), scene.views);
  }

  std::vector<ViewMasks> find(const Inventory& inventory, const Queries& queries) {
    for (size_t v = 0; v < scene_.views.size(); ++v) {
      const SceneView& view = scene_.views[v];
      std::set<std::string> texts;
      for (const auto& [key, query] : queries) {
        const bool here = std::find(query.views.begin(), query.views.end(), view.name) != query.views.end();
        if (here && !is_only_part(inventory, key)) texts.insert(query.text);
      }
      for (const std::string& text : texts) {
        if (found_[v].count(text) > 0) continue;
        found_[v][text] = models_.find(fmt::format("{}_{}", view.name, ++asked_[v]), pngs_[v], text, view.camera.width,
                                       view.camera.height);
      }
    }
    return assign_instances(inventory, queries, found_, scene_.views, support_);
  }

 private:
  // The only part of an object has the object's mask.
  static bool is_only_part(const Inventory& inventory, const std::string& key) {
    const int r = inventory.find_row(key);
    return r >= 0 && std::count_if(inventory.rows.begin(), inventory.rows.end(), [&](const InventoryRow& row) {
                       return !row.residual && row.object == inventory.rows[r].object;
                     }) == 1;
  }

  const Scene& scene_;
  MaskModels& models_;
  FoundMasks found_;
  std::vector<int> asked_;
  std::vector<std::string> pngs_;
  GaussianSupport support_;
};

void report(const Inventory& inventory, const MaskSource& source, Perception& perception) {
  for (const std::string& key : without_support(inventory, perception.views)) {
    const int r = inventory.find_row(key);
    const bool unhinted =
        r >= 0 && inventory.rows[r].hints.empty() && source.folder.empty() && source.models == nullptr;
    perception.omitted.push_back(
        {"masks of " + key, unhinted ? "it has no hints and its object has other rows" : "no view shows it"});
  }
  for (const ViewMasks& view : perception.views) {
    for (Omission& doubt : doubts_about(inventory, view)) perception.omitted.push_back(std::move(doubt));
  }
}

}  // namespace

Perception perceive(const Scene& scene, Inventory& inventory, const std::vector<ViewPicture>& pictures,
                    const MaskSource& source) {
  Perception perception;
  std::vector<ViewImage> images;
  std::vector<std::string> names;
  for (const SceneView& view : scene.views) {
    images.push_back(load_view_image(view));
    names.push_back(view.name);
    perception.files.push_back(view.image);
  }
  if (!source.folder.empty()) {
    perception.views = load_mask_files(source.folder, inventory, scene, perception.files);
  } else {
    Queries queries = source.planner ? source.planner(inventory, {}, {}) : queries_of(inventory, names);
    std::optional<ModelSearch> search;
    if (source.models != nullptr) {
      search.emplace(scene, pictures, *source.models);
      perception.files.push_back(scene.gaussians);
    }
    std::vector<Omission> unrefined;  // of the last attempt
    const auto attempt = [&] {
      unrefined.clear();
      perception.views.clear();
      if (search) {
        perception.views = search->find(inventory, queries);
        return;
      }
      for (Segmentation& view : segment_views(images, inventory, scene.run)) {
        perception.views.push_back(std::move(view.masks));
        unrefined.insert(unrefined.end(), view.omitted.begin(), view.omitted.end());
      }
    };
    attempt();
    const std::vector<std::string> missed = without_support(inventory, perception.views);
    if (!missed.empty() && (source.models != nullptr || source.planner)) {
      const Queries repaired =
          source.planner ? source.planner(inventory, missed, queries) : wider_queries(inventory, names, missed);
      for (const auto& [key, query] : repaired) queries[key] = query;
      perception.omitted.push_back({"masks of the first attempt", "nothing was found of " + join(missed)});
      attempt();
    }
    perception.omitted.insert(perception.omitted.end(), unrefined.begin(), unrefined.end());
  }
  report(inventory, source, perception);
  const bool anything = std::any_of(perception.views.begin(), perception.views.end(), [](const ViewMasks& view) {
    return std::any_of(view.objects.begin(), view.objects.end(), [](const Mask& mask) { return !mask.empty(); });
  });
  if (!anything) {
    throw invalid_input({scene.file, "/views", "views in which nothing of the inventory was found",
                         "an object in front of the background (run.render.background)",
                         "check the background colour, the hints or the masks"});
  }
  return perception;
}

}  // namespace physmas::masks
