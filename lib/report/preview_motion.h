// The coarse motion of a preview, in pictures.
#ifndef PHYSMAS_REPORT_PREVIEW_MOTION_H
#define PHYSMAS_REPORT_PREVIEW_MOTION_H

#include <string>
#include <vector>

#include "records/scene.h"
#include "report/run_records.h"
#include "scene/gaussians.h"
#include "scene/image.h"

namespace physmas::report {

struct PreviewMotion {
  std::vector<double> times;    // [T] s
  std::vector<Image> pictures;  // [T] of one size
  std::string about;            // a sentence: how rough it is, and where it ends too early
  std::string why_not;          // where there are no pictures
};

// Of the first candidate of the first round that moves at all, simulated on few cells (bind/coarse_motion.h), each
// Gaussian carried by the coarse particles of its row that are near it. scene: with its Gaussians' file and output
// cameras; the first of these looks on, moved back so that what moves stays in the picture.
PreviewMotion preview_motion(const RunRecords& run, const Scene& scene, const Gaussians& gaussians);

}  // namespace physmas::report

#endif
