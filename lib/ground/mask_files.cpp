#include "ground/mask_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <set>

#include "base/error.h"
#include "scene/image.h"
#include "splat/image_io.h"

namespace fs = std::filesystem;

namespace physmas::ground {
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
  const Image image = splat::load_image(path.string());
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

}  // namespace

std::vector<ViewMasks> load_mask_files(const std::string& folder, const Inventory& inventory,
                                       const std::vector<SceneView>& views, std::vector<std::string>& files) {
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
    const auto view = std::find_if(views.begin(), views.end(),
                                   [&](const SceneView& s) { return s.name == view_folder.filename().string(); });
    if (view == views.end()) throw unknown(view_folder, "folders named after the scene's views");
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
  if (files.empty()) throw invalid_input({folder, "", "no masks", "VIEW/OBJECT.png or VIEW/OBJECT/PART.png"});
  for (ViewMasks& masks : all) {
    for (size_t o = 0; o < inventory.objects.size(); ++o) complete_object(inventory, o, masks);
  }
  return all;
}

}  // namespace physmas::ground
