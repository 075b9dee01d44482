// Masks of all views from the chosen source, and a report of what they leave open.
#ifndef PHYSMAS_GROUND_PERCEPTION_H
#define PHYSMAS_GROUND_PERCEPTION_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "records/provenance.h"
#include "scene/scene.h"

namespace physmas::ground {

struct Perception {
  std::vector<ViewMasks> views;    // in scene order
  std::vector<Omission> omitted;   // objects and rows that no view shows
  std::vector<std::string> files;  // images and mask files that were read
};

// mask_folder: read masks from there; empty: the built-in segmenter. The views' images are read and checked either
// way. Errors (exit code 3) as load_view_image and load_mask_files; and when no view shows anything.
Perception perceive(const Scene& scene, const Inventory& inventory, const std::string& mask_folder);

}  // namespace physmas::ground

#endif
