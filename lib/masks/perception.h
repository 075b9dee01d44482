// Masks of all views from the chosen source, and a report of what they leave open.
#ifndef PHYSMAS_MASKS_PERCEPTION_H
#define PHYSMAS_MASKS_PERCEPTION_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "masks/instances.h"
#include "masks/mask_models.h"
#include "masks/view_image.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/provenance.h"
#include "records/scene.h"
#include "scene/view_pictures.h"

namespace physmas::masks {

// Plans what models and hints look for: all keys of `inventory` where `missed` is empty, else repairs of these with
// what was tried for them. May give `inventory` hints.
using QueryPlanner =
    std::function<Queries(Inventory& inventory, const std::vector<std::string>& missed, const Queries& tried)>;

// Who makes the masks: a folder of files, a detector with a segmenter, or (neither given) the built-in segmenter.
struct MaskSource {
  std::string folder;
  MaskModels* models = nullptr;
  QueryPlanner planner;  // none: the inventory's own texts
};

struct Perception {
  std::vector<ViewMasks> views;    // in scene order
  std::vector<Omission> omitted;   // what no view shows, masks that are suspect, and that there was a second attempt
  std::vector<std::string> files;  // images, mask files and, where they told things apart, the Gaussians
};

// At most two attempts (paper, "Perception Configuration"), the second only with models or an agent and only where the
// first left an object or row without a mask. The views' images are read and checked in any case. The agent may give
// `inventory` queries and hints.
// Errors: exit code 3 as load_view_image and load_mask_files, and when no view shows anything; exit code 4 as
// MaskModels and ChatAgent.
Perception perceive(const Scene& scene, Inventory& inventory, const std::vector<ViewPicture>& pictures,
                    const MaskSource& source);

}  // namespace physmas::masks

#endif
