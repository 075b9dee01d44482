// Masks that somebody drew: VIEW/OBJECT.png and VIEW/OBJECT/PART.png.
#ifndef PHYSMAS_GROUND_MASK_FILES_H
#define PHYSMAS_GROUND_MASK_FILES_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "scene/scene.h"

namespace physmas::ground {

// Values above 127 are inside: of the grey, of the brightest colour channel, or of alpha where there is one. Confidence
// 1, source "file". An object without a file is the union of its parts; a single part without a file is its object.
// Every PNG that was read is appended to `files`. Errors (exit code 3): a file or folder that is no view, object or
// part, no masks at all, a mask of another size than its view's camera.
std::vector<ViewMasks> load_mask_files(const std::string& folder, const Inventory& inventory,
                                       const std::vector<SceneView>& views, std::vector<std::string>& files);

}  // namespace physmas::ground

#endif
