// Masks that somebody or another tool drew: VIEW/OBJECT.png and VIEW/OBJECT/PART.png, or COCO JSON.
#ifndef PHYSMAS_MASKS_MASK_FILES_H
#define PHYSMAS_MASKS_MASK_FILES_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "records/scene.h"

namespace physmas::masks {

// PNG: values above 127 are inside: of the grey, of the brightest colour channel, or of alpha where there is one.
// Confidence 1. COCO: every *.json beside the view folders, see coco.h; a name is an id, a key, or the words of a name.
// Several masks of one name are united. A name that several objects or parts share is settled by assign_instances,
// with the scene's Gaussians. Source "file". An object without a mask is the union of its parts; a single part without
// a mask is its object.
// Every file that was read is appended to `files`. Errors (exit code 3): a file, folder or name that is no view, object
// or part, no masks at all, a mask of another size than its view's camera.
std::vector<ViewMasks> load_mask_files(const std::string& folder, const Inventory& inventory, const Scene& scene,
                                       std::vector<std::string>& files);

// The last two rules for the masks of one view.
void complete_objects(const Inventory& inventory, ViewMasks& masks);

}  // namespace physmas::masks

#endif
