// masks.h5: one mask per view and object, and per view and row, with its confidence and source.
#ifndef PHYSMAS_RECORDS_MASKS_H
#define PHYSMAS_RECORDS_MASKS_H

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas {

// Least confidence of an observed mask (paper, Table "lifting-settings").
constexpr double kMaskConfidenceFloor = 0.05;

struct Mask {
  int width = 0, height = 0;    // of the view's camera
  std::vector<uint8_t> pixels;  // [height * width] by rows: 0 outside, 255 inside
  double confidence = 0;        // 0..1
  std::string source;           // who made it: "hints", "file", "alpha", ...
  bool empty() const { return pixels.empty(); }
  // The confidence with its floor: what an observed mask counts, whatever its maker says of it.
  double floored_confidence() const { return std::max(confidence, kMaskConfidenceFloor); }
  // Number of pixels inside.
  long area() const;
};

// Number of pixels inside both masks of one view; 0 where one is empty.
long common_area(const Mask& a, const Mask& b);

// Masks are empty where a view does not show the object or the row.
struct ViewMasks {
  std::string view;
  std::vector<Mask> objects;  // [inventory.objects]
  std::vector<Mask> rows;     // [inventory.rows]
};

// Views come in the order of `view_names`; every mask must have its view's image size.
std::vector<ViewMasks> load_masks(const std::string& path, const Inventory& inventory,
                                  const std::vector<std::string>& view_names);
// omitted: why masks are missing, stored as the root attribute `omitted`.
void save_masks(const std::string& path, const Inventory& inventory, const std::vector<ViewMasks>& views,
                const std::vector<Omission>& omitted, const Provenance& provenance);

}  // namespace physmas

#endif
