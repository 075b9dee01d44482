#include "records/masks.h"

#include <algorithm>

#include "records/hdf5_file.h"
#include "records/json.h"

namespace physmas {
namespace {

constexpr uint64_t kMaxPixels = uint64_t{16384} * 16384;

Mask read_mask(const Hdf5Reader& file, const std::string& name) {
  Mask mask;
  mask.pixels = file.read_byte(name, {UINT64_MAX, UINT64_MAX}, kMaxPixels);
  const std::vector<uint64_t> shape = file.shape(name);
  mask.height = static_cast<int>(shape[0]);
  mask.width = static_cast<int>(shape[1]);
  mask.confidence = file.read_attribute(name, "confidence", 1)[0];
  if (mask.confidence < 0 || mask.confidence > 1)
    throw file.invalid(name + "/@confidence", std::to_string(mask.confidence), "a number in 0..1");
  mask.source = file.read_text_attribute(name, "source");
  return mask;
}

void write_mask(Hdf5Writer& file, const std::string& name, const Mask& mask) {
  if (mask.empty()) return;
  file.write_byte(name, {static_cast<uint64_t>(mask.height), static_cast<uint64_t>(mask.width)}, mask.pixels.data());
  file.write_attribute(name, "confidence", {mask.confidence});
  file.write_text_attribute(name, "source", mask.source);
}

}  // namespace

long Mask::area() const {
  return static_cast<long>(pixels.size()) - std::count(pixels.begin(), pixels.end(), uint8_t{0});
}

long common_area(const Mask& a, const Mask& b) {
  if (a.empty() || b.empty()) return 0;
  long count = 0;
  for (size_t p = 0; p < a.pixels.size(); ++p) count += a.pixels[p] != 0 && b.pixels[p] != 0;
  return count;
}

std::vector<ViewMasks> load_masks(const std::string& path, const Inventory& inventory,
                                  const std::vector<std::string>& view_names) {
  const Hdf5Reader file(path, "masks");
  // A mask of something that the inventory does not know is a mix-up of files, not a detail to skip.
  for (const std::string& view : file.names_in("/views")) {
    if (std::find(view_names.begin(), view_names.end(), view) == view_names.end())
      throw file.invalid("/views/" + view, "an unknown view", "the scene's views only");
    for (const std::string& object : file.names_in("/views/" + view + "/objects")) {
      if (inventory.find_object(object) < 0)
        throw file.invalid("/views/" + view + "/objects/" + object, "an unknown object",
                           "objects of the inventory only");
    }
    for (const std::string& object : file.names_in("/views/" + view + "/rows")) {
      for (const std::string& part : file.names_in("/views/" + view + "/rows/" + object)) {
        if (inventory.find_row(object + "/" + part) < 0)
          throw file.invalid("/views/" + view + "/rows/" + object + "/" + part, "an unknown row key",
                             "rows of the inventory only");
      }
    }
  }
  std::vector<ViewMasks> views;
  std::vector<std::string> datasets;
  for (const std::string& name : view_names) {
    for (const InventoryObject& object : inventory.objects)
      datasets.push_back("/views/" + name + "/objects/" + object.id);
    for (const InventoryRow& row : inventory.rows) datasets.push_back("/views/" + name + "/rows/" + row.key());
  }
  file.allow_only(datasets);
  for (const std::string& name : view_names) {
    const std::string group = "/views/" + name;
    if (!file.exists(group)) throw file.invalid(group, "nothing", "masks of this view");
    ViewMasks view;
    view.view = name;
    for (const InventoryObject& object : inventory.objects) {
      const std::string dataset = group + "/objects/" + object.id;
      view.objects.push_back(file.exists(dataset) ? read_mask(file, dataset) : Mask());
    }
    for (const InventoryRow& row : inventory.rows) {
      const std::string dataset = group + "/rows/" + row.key();
      view.rows.push_back(file.exists(dataset) ? read_mask(file, dataset) : Mask());
    }
    views.push_back(std::move(view));
  }
  return views;
}

void save_masks(const std::string& path, const Inventory& inventory, const std::vector<ViewMasks>& views,
                const std::vector<Omission>& omitted, const Provenance& provenance) {
  Hdf5Writer file(path, "masks", provenance);
  file.write_text_attribute("/", "omitted", compact_text(to_json(omitted)));
  for (const ViewMasks& view : views) {
    const std::string group = "/views/" + view.view;
    file.make_group(group);
    file.make_group(group + "/objects");
    file.make_group(group + "/rows");
    for (size_t o = 0; o < inventory.objects.size(); ++o)
      write_mask(file, group + "/objects/" + inventory.objects[o].id, view.objects[o]);
    for (const InventoryObject& object : inventory.objects) {
      for (size_t r = 0; r < inventory.rows.size(); ++r) {
        if (inventory.rows[r].object != object.id || view.rows[r].empty()) continue;
        file.make_group(group + "/rows/" + object.id);
        write_mask(file, group + "/rows/" + inventory.rows[r].key(), view.rows[r]);
      }
    }
  }
  file.commit();
}

}  // namespace physmas
