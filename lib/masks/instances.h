// Which object or part every found mask belongs to, the same in all views (paper, "Perception Configuration": the
// front view's inventory defines the query ids; projection-consistent Gaussian support and the fixed query order match
// masks in the remaining views).
#ifndef PHYSMAS_MASKS_INSTANCES_H
#define PHYSMAS_MASKS_INSTANCES_H

#include <map>
#include <string>
#include <vector>

#include "masks/queries.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/scene.h"
#include "scene/gaussians.h"

namespace physmas::masks {

// Masks that were found for a text, in order of preference. [view] text -> masks of that view's size
using FoundMasks = std::vector<std::map<std::string, std::vector<Mask>>>;

// Where Gaussians show in the views: what ties masks of different views together.
struct GaussianSupport {
  std::vector<std::vector<int32_t>> pixel;    // [view][N] index of the pixel, -1 outside the image
  std::vector<std::vector<uint8_t>> visible;  // [view][N] 1 where the view sees the Gaussian
};
GaussianSupport support_in_views(const Gaussians& gaussians, const std::vector<SceneView>& views);

// A mask belongs to an object only if at least this share of the Gaussians that it shows may be the object's.
constexpr double kConsistentShare = 0.5;

// Objects first. Objects with one text take the first view's strongest masks for it, as many as they are; in query
// order from left to right. In every later view the mask with the largest share of visible Gaussians that lie inside
// the object's masks of the views before goes to it, from kConsistentShare, ties by query order. Parts then take every
// mask for their text that lies at least half inside their object's mask, cut to it, with the mean confidence by area.
// Without a mask of its own an object is the union of its parts, and a single part is its object.
// Texts that no query has are ignored. given: masks that are settled already, [views] or empty; they stay.
std::vector<ViewMasks> assign_instances(const Inventory& inventory, const Queries& queries, const FoundMasks& found,
                                        const std::vector<SceneView>& views, const GaussianSupport& support,
                                        std::vector<ViewMasks> given = {});

}  // namespace physmas::masks

#endif
