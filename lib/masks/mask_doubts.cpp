#include "masks/mask_doubts.h"

#include <fmt/format.h>

namespace physmas::masks {
namespace {

bool covers_everything(const Mask& mask) {
  return !mask.empty() && mask.area() == static_cast<long>(mask.pixels.size());
}

}  // namespace

std::vector<Omission> doubts_about(const Inventory& inventory, const ViewMasks& view) {
  std::vector<Omission> doubts;
  const auto doubt = [&](const std::string& key, const std::string& why) {
    doubts.push_back({fmt::format("doubt about the mask of {} in {}", key, view.view), why});
  };
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    if (covers_everything(view.objects[o])) doubt(inventory.objects[o].id, "it covers the whole image");
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const Mask& part = view.rows[r];
    if (covers_everything(part)) doubt(inventory.rows[r].key(), "it covers the whole image");
    const int own = inventory.object_of_row(static_cast<int>(r));
    const double inside = static_cast<double>(common_area(part, view.objects[own])), area = part.area();
    if (part.empty() || inside >= (1 - kOutside) * area) continue;
    std::string where = "outside its object";
    for (size_t o = 0; o < inventory.objects.size(); ++o) {
      if (static_cast<double>(common_area(part, view.objects[o])) > kOutside * area)
        where = "in " + inventory.objects[o].id;
    }
    doubt(inventory.rows[r].key(), "most of it lies " + where);
  }
  for (size_t a = 0; a < inventory.objects.size(); ++a) {
    for (size_t b = a + 1; b < inventory.objects.size(); ++b) {
      const Mask &x = view.objects[a], &y = view.objects[b];
      const long both = common_area(x, y);
      if (both == 0 || static_cast<double>(both) <= kSameMask * static_cast<double>(x.area() + y.area() - both))
        continue;
      doubts.push_back({fmt::format("doubt about the masks of {} and {} in {}", inventory.objects[a].id,
                                    inventory.objects[b].id, view.view),
                        "they cover the same pixels"});
    }
  }
  return doubts;
}

}  // namespace physmas::masks
