// Masks in COCO JSON, as COCO tools and Grounded-SAM scripts write them.
#ifndef PHYSMAS_MASKS_COCO_H
#define PHYSMAS_MASKS_COCO_H

#include <cstdint>
#include <string>
#include <vector>

#include "records/json_fwd.h"
#include "records/masks.h"
#include "records/scene.h"

namespace physmas::masks {

struct NamedMask {
  size_t view = 0;   // index into the scene's views
  std::string name;  // of its category or class
  Mask mask;         // confidence: the annotation's score, 1 without; source "file"
};

// Every annotation of one file, in its order; those without a pixel are left out. The view is the stem of the image's
// `file_name` (COCO), else of the file itself; the name is the category's, or `class_name` (Grounded-SAM 2).
// `segmentation`: RLE with counts as text (compressed) or as a list, or a list of polygons in pixels.
// Errors (exit code 3) name the file and the field: no view of that name, a mask of another size than its view's
// camera, runs that do not fill it, more than 4096 annotations.
std::vector<NamedMask> load_coco(const std::string& path, const std::vector<SceneView>& views);

// The same from a parsed file; `file` is its path.
std::vector<NamedMask> coco_from(const Json& document, const std::string& file, const std::vector<SceneView>& views);

// Runs of pixels outside and inside in turn, by columns: COCO's text form (LEB128 of six bits, differences to the run
// before the last from the third on; pycocotools, maskApi.c). An invalid text gives an empty list.
std::vector<uint32_t> runs_from_text(const std::string& text);

}  // namespace physmas::masks

#endif
