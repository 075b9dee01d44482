#include "masks/mask_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/words.h"
#include "masks/coco.h"
#include "masks/instances.h"
#include "records/reference.h"
#include "scene/gaussian_files.h"
#include "scene/image.h"
#include "scene/image_file.h"

namespace fs = std::filesystem;

namespace physmas::masks {
namespace {

constexpr int kInside = 127;  // of 255

// Entries of a folder, sorted by name.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code failure;
  std::set<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) entries.insert(entry.path());
  if (failure) throw system_error(folder.string(), "cannot be read", failure.value());
  return {entries.begin(), entries.end()};
}

Mask read_mask_file(const fs::path& path, const SceneView& view) {
  const Image image = load_image(path.string());
  if (image.width != view.camera.width || image.height != view.camera.height) {
    throw invalid_input({path.string(), "", fmt::format("a mask of {} x {} pixels", image.width, image.height),
                         fmt::format("{} x {}, the size of the camera of view \"{}\"", view.camera.width,
                                     view.camera.height, view.name)});
  }
  Mask mask;
  mask.width = image.width;
  mask.height = image.height;
  mask.confidence = 1;
  mask.source = "file";
  mask.pixels.resize(static_cast<size_t>(image.width) * image.height);
  for (size_t i = 0; i < mask.pixels.size(); ++i) {
    const uint8_t* p = &image.pixels[i * image.channels];
    const int value = image.channels == 3 ? std::max({p[0], p[1], p[2]}) : p[image.channels - 1];
    mask.pixels[i] = value > kInside ? 255 : 0;
  }
  return mask.area() > 0 ? mask : Mask();
}

Error unknown(const fs::path& path, const std::string& expected) {
  return invalid_input({path.string(), "", "a name that the inventory does not have", expected,
                        "rename or remove it, or add it to the inventory"});
}

void complete_object(const Inventory& inventory, size_t o, ViewMasks& masks) {
  std::vector<size_t> rows;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].object == inventory.objects[o].id && !inventory.rows[r].residual) rows.push_back(r);
  }
  Mask& object = masks.objects[o];
  if (object.empty()) {
    for (const size_t r : rows) {
      const Mask& part = masks.rows[r];
      if (part.empty()) continue;
      if (object.empty()) object = part;
      std::transform(part.pixels.begin(), part.pixels.end(), object.pixels.begin(), object.pixels.begin(),
                     [](uint8_t a, uint8_t b) { return std::max(a, b); });
    }
  } else if (rows.size() == 1 && masks.rows[rows[0]].empty()) {
    masks.rows[rows[0]] = object;
  }
}

void unite(const Mask& mask, Mask& with) {
  if (with.empty()) {
    with = mask;
    return;
  }
  const double a = static_cast<double>(mask.area()), b = static_cast<double>(with.area());
  with.confidence = (a * mask.confidence + b * with.confidence) / (a + b);
  for (size_t p = 0; p < mask.pixels.size(); ++p) with.pixels[p] |= mask.pixels[p];
}

// Masks with names of one COCO file: those that one thing can mean go into `all`, the rest into `found`.
void sort_by_name(const std::string& path, const Inventory& inventory, const std::vector<SceneView>& views,
                  std::vector<ViewMasks>& all, FoundMasks& found, Queries& shared) {
  std::vector<std::string> view_names;
  for (const SceneView& view : views) view_names.push_back(view.name);
  const std::vector<std::string> known = all_references(inventory);
  for (NamedMask& named : load_coco(path, views)) {
    std::vector<std::string> meant = {named.name};
    if (std::find(known.begin(), known.end(), named.name) == known.end())
      meant = find_references(inventory, name_words(named.name));
    if (meant.empty()) {
      throw invalid_input(
          {path, "/annotations", "the name \"" + one_line(named.name, 80) + "\"", "one of " + one_line(join(known))});
    }
    if (meant.size() > 1) {
      for (const std::string& key : meant) shared[key] = {named.name, view_names};
      found[named.view][named.name].push_back(std::move(named.mask));
      continue;
    }
    const int object = inventory.find_object(meant[0]);
    unite(named.mask,
          object >= 0 ? all[named.view].objects[object] : all[named.view].rows[inventory.find_row(meant[0])]);
  }
}

}  // namespace

void complete_objects(const Inventory& inventory, ViewMasks& masks) {
  for (size_t o = 0; o < inventory.objects.size(); ++o) complete_object(inventory, o, masks);
}

std::vector<ViewMasks> load_mask_files(const std::string& folder, const Inventory& inventory, const Scene& scene,
                                       std::vector<std::string>& files) {
  const std::vector<SceneView>& views = scene.views;
  const size_t files_before = files.size();
  FoundMasks found(views.size());
  Queries shared;
  std::vector<ViewMasks> all;
  for (const SceneView& view : views) {
    ViewMasks masks;
    masks.view = view.name;
    masks.objects.resize(inventory.objects.size());
    masks.rows.resize(inventory.rows.size());
    all.push_back(std::move(masks));
  }
  const auto read = [&](const fs::path& path, size_t v, Mask& mask) {
    mask = read_mask_file(path, views[v]);
    files.push_back(path.string());
  };
  for (const fs::path& view_folder : entries_of(folder)) {
    if (view_folder.extension() == ".json") {
      sort_by_name(view_folder.string(), inventory, views, all, found, shared);
      files.push_back(view_folder.string());
      continue;
    }
    const auto view = std::find_if(views.begin(), views.end(),
                                   [&](const SceneView& s) { return s.name == view_folder.filename().string(); });
    if (view == views.end()) throw unknown(view_folder, "folders named after the scene's views, or COCO JSON");
    const size_t v = view - views.begin();
    for (const fs::path& entry : entries_of(view_folder)) {
      const int object = inventory.find_object(entry.stem().string());
      if (object < 0) throw unknown(entry, "OBJECT.png or a folder OBJECT");
      if (!fs::is_directory(entry)) {
        if (entry.extension() != ".png") throw unknown(entry, "OBJECT.png or a folder OBJECT");
        read(entry, v, all[v].objects[object]);
        continue;
      }
      for (const fs::path& part : entries_of(entry)) {
        const int row = inventory.find_row(inventory.objects[object].id + "/" + part.stem().string());
        if (row < 0 || part.extension() != ".png") throw unknown(part, "PART.png of this object");
        read(part, v, all[v].rows[row]);
      }
    }
  }
  if (files.size() == files_before)
    throw invalid_input({folder, "", "no masks", "VIEW/OBJECT.png, VIEW/OBJECT/PART.png or COCO JSON"});
  if (!shared.empty()) {
    if (scene.gaussians.empty()) {
      throw invalid_input({folder, "",
                           "the name \"" + one_line(shared.begin()->second.text, 80) + "\", which several things share",
                           "ids or keys as names: " + scene.file + " has no Gaussians to tell them apart by"});
    }
    const GaussianSupport support = support_in_views(load_gaussians(scene.gaussians), views);
    return assign_instances(inventory, shared, found, views, support, std::move(all));
  }
  for (ViewMasks& masks : all) complete_objects(inventory, masks);
  return all;
}

}  // namespace physmas::masks
