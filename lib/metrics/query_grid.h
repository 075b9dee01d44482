// The fixed query grid of the paper's motion metrics, and target masks as files.
#ifndef PHYSMAS_METRICS_QUERY_GRID_H
#define PHYSMAS_METRICS_QUERY_GRID_H

#include <string>
#include <vector>

#include "metrics/motion.h"
#include "scene/image.h"

namespace physmas::metrics {

// The grid lies over the whole image: kGrid × kGrid cells, a query at each centre.
constexpr int kGrid = 16;

struct QueryPixel {
  int x = 0, y = 0;
};
// Queries inside the mask (1 channel, nonzero: target) eroded by one pixel: pixels whose 3 × 3 neighbourhood lies in
// the mask and in the image. By rows.
std::vector<QueryPixel> query_pixels(const Image& mask);

// Masks of a video: folder/*.png in the order of their names, one per frame, grey, of one size; above 127 is the
// target. Errors (exit code 3): no PNG files, more than 10,000, other sizes.
std::vector<Image> load_masks(const std::string& folder);

// Hides every point that does not lie in its frame's target mask. masks: [T], of the tracks' size; other numbers or
// sizes are an Error (exit code 3) that names `source`.
void restrict_to_masks(Tracks& tracks, const std::vector<Image>& masks, const std::string& source);

// Pixels of the target, [T].
std::vector<long> mask_areas(const std::vector<Image>& masks);

}  // namespace physmas::metrics

#endif
