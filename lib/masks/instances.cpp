#include "masks/instances.h"

#include <algorithm>
#include <numeric>

#include "masks/mask_files.h"
#include "splat/visibility.h"

namespace physmas::masks {
namespace {

constexpr double kInsideShare = 0.5;  // of a part's mask inside its object's

double center_x(const Mask& mask) {
  double sum = 0;
  long count = 0;
  for (size_t p = 0; p < mask.pixels.size(); ++p) {
    if (mask.pixels[p] == 0) continue;
    sum += static_cast<double>(p % mask.width);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

bool is_queried(const Queries& queries, const std::string& key, const std::string& text, const std::string& view) {
  const auto query = queries.find(key);
  return query != queries.end() && query->second.text == text &&
         std::find(query->second.views.begin(), query->second.views.end(), view) != query->second.views.end();
}

class Matcher {
 public:
  Matcher(const Inventory& inventory, const Queries& queries, const FoundMasks& found,
          const std::vector<SceneView>& views, const GaussianSupport& support, std::vector<ViewMasks> given)
      : inventory_(inventory), queries_(queries), found_(found), views_(views), support_(support) {
    const size_t n = support.pixel.empty() ? 0 : support.pixel[0].size();
    may_be_.assign(inventory.objects.size(), std::vector<uint8_t>(n, 1));
    placed_.assign(inventory.objects.size(), 0);
    for (const SceneView& view : views) {
      ViewMasks masks;
      masks.view = view.name;
      masks.objects.resize(inventory.objects.size());
      masks.rows.resize(inventory.rows.size());
      masks_.push_back(std::move(masks));
    }
    for (size_t v = 0; v < given.size(); ++v) {
      masks_[v].rows = given[v].rows;
      for (size_t o = 0; o < inventory.objects.size(); ++o) {
        if (!given[v].objects[o].empty()) place(given[v].objects[o], v, o);
      }
    }
  }

  std::vector<ViewMasks> match() {
    for (size_t v = 0; v < views_.size(); ++v) {
      for (const auto& [text, masks] : found_[v]) match_objects(v, text, masks);
    }
    for (size_t v = 0; v < views_.size(); ++v) {
      match_parts(v);
      complete_objects(inventory_, masks_[v]);
    }
    return std::move(masks_);
  }

 private:
  bool inside(const Mask& mask, size_t v, size_t i) const {
    const int32_t p = support_.pixel[v][i];
    return p >= 0 && mask.pixels[p] != 0;
  }

  // Share of the Gaussians that `mask` shows which may be object o's.
  double consistency(const Mask& mask, size_t v, size_t o) const {
    long shown = 0, consistent = 0;
    for (size_t i = 0; i < may_be_[o].size(); ++i) {
      if (support_.visible[v][i] == 0 || !inside(mask, v, i)) continue;
      ++shown;
      consistent += may_be_[o][i];
    }
    return shown > 0 ? static_cast<double>(consistent) / static_cast<double>(shown) : 0;
  }

  void place(const Mask& mask, size_t v, size_t o) {
    masks_[v].objects[o] = mask;
    placed_[o] = 1;
    for (size_t i = 0; i < may_be_[o].size(); ++i) {
      if (support_.pixel[v][i] >= 0 && !inside(mask, v, i)) may_be_[o][i] = 0;
    }
  }

  void match_objects(size_t v, const std::string& text, const std::vector<Mask>& masks) {
    std::vector<size_t> known, fresh;  // objects with this text, in query order
    for (size_t o = 0; o < inventory_.objects.size(); ++o) {
      if (masks_[v].objects[o].empty() && is_queried(queries_, inventory_.objects[o].id, text, views_[v].name))
        (placed_[o] != 0 ? known : fresh).push_back(o);
    }
    std::vector<size_t> left(masks.size());
    std::iota(left.begin(), left.end(), size_t{0});
    while (!known.empty() && !left.empty()) {
      double best = -1;
      size_t best_k = 0, best_m = 0;
      for (size_t k = 0; k < known.size(); ++k) {
        for (size_t m = 0; m < left.size(); ++m) {
          const double share = consistency(masks[left[m]], v, known[k]);
          if (share > best) best = share, best_k = k, best_m = m;
        }
      }
      if (best < kConsistentShare) break;
      place(masks[left[best_m]], v, known[best_k]);
      known.erase(known.begin() + static_cast<long>(best_k));
      left.erase(left.begin() + static_cast<long>(best_m));
    }
    // Objects that no earlier view has shown: the strongest of the rest, left to right.
    left.resize(std::min(left.size(), fresh.size()));
    std::stable_sort(left.begin(), left.end(),
                     [&](size_t a, size_t b) { return center_x(masks[a]) < center_x(masks[b]); });
    for (size_t k = 0; k < left.size(); ++k) place(masks[left[k]], v, fresh[k]);
  }

  void match_parts(size_t v) {
    for (size_t r = 0; r < inventory_.rows.size(); ++r) {
      const InventoryRow& row = inventory_.rows[r];
      const auto query = queries_.find(row.key());
      if (row.residual || query == queries_.end() ||
          !is_queried(queries_, row.key(), query->second.text, views_[v].name)) {
        continue;
      }
      const auto found = found_[v].find(query->second.text);
      if (found == found_[v].end()) continue;
      const size_t own = inventory_.object_of_row(static_cast<int>(r));
      Mask& united = masks_[v].rows[r];
      if (!united.empty()) continue;
      double weighted = 0, total = 0;
      for (const Mask& mask : found->second) {
        if (!belongs_to(mask, v, own)) continue;
        const Mask& object = masks_[v].objects[own];
        if (united.empty()) {
          united = mask;
          std::fill(united.pixels.begin(), united.pixels.end(), uint8_t{0});
        }
        for (size_t p = 0; p < mask.pixels.size(); ++p) {
          if (mask.pixels[p] != 0 && (object.empty() || object.pixels[p] != 0)) united.pixels[p] = 255;
        }
        const double area = static_cast<double>(mask.area());
        weighted += mask.confidence * area;
        total += area;
      }
      if (total > 0) united.confidence = weighted / total;
    }
  }

  // Whether a part's mask lies in object o: at least half, and nowhere more; without any object mask, if it is alone.
  bool belongs_to(const Mask& mask, size_t v, size_t o) const {
    const std::vector<Mask>& objects = masks_[v].objects;
    if (objects[o].empty()) return inventory_.objects.size() == 1;
    const long own = common_area(mask, objects[o]);
    if (static_cast<double>(own) < kInsideShare * static_cast<double>(mask.area())) return false;
    for (size_t other = 0; other < objects.size(); ++other) {
      const long there = other == o ? 0 : common_area(mask, objects[other]);
      if (there > own || (there == own && other < o && there > 0)) return false;
    }
    return true;
  }

  const Inventory& inventory_;
  const Queries& queries_;
  const FoundMasks& found_;
  const std::vector<SceneView>& views_;
  const GaussianSupport& support_;
  std::vector<std::vector<uint8_t>> may_be_;  // [object][N] 1: inside all of the object's masks so far
  std::vector<uint8_t> placed_;               // [object] 1: some view before shows it
  std::vector<ViewMasks> masks_;
};

}  // namespace

GaussianSupport support_in_views(const Gaussians& gaussians, const std::vector<SceneView>& views) {
  std::vector<Camera> cameras;
  GaussianSupport support;
  for (const SceneView& view : views) {
    cameras.push_back(view.camera);
    support.pixel.push_back(splat::project_to_pixels(gaussians.position, view.camera));
  }
  support.visible = splat::visible_in_views(gaussians, cameras);
  return support;
}

std::vector<ViewMasks> assign_instances(const Inventory& inventory, const Queries& queries, const FoundMasks& found,
                                        const std::vector<SceneView>& views, const GaussianSupport& support,
                                        std::vector<ViewMasks> given) {
  return Matcher(inventory, queries, found, views, support, std::move(given)).match();
}

}  // namespace physmas::masks
