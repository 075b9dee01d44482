// From masks to one row per Gaussian (paper, Eqs. objectscore and partscore, Appendix "Object-Part Lifting").
#ifndef PHYSMAS_LIFT_ASSIGNMENT_H
#define PHYSMAS_LIFT_ASSIGNMENT_H

#include <cstdint>
#include <string>
#include <vector>

#include "lift/agreement.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/run_specification.h"
#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::lift {

struct Labels {
  std::vector<int32_t> object;  // [N] index into inventory.objects
  std::vector<int32_t> row;     // [N] index into inventory.rows, of that object
  std::vector<float>
      confidence;  // [N] 0..1: mean part evidence over Omega_i; at most 0.20 for residual, voted and rescued ones
  // How they came about.
  struct Counts {
    long unseen = 0;        // Gaussians in no view
    long object_votes = 0;  // ambiguous ones that their neighbours decided
    long part_votes = 0;
    long residual = 0;  // in a residual row at the end
    long hidden = 0;    // depth test: in some view's image, but seen in none
    long rescued = 0;   // out of a residual row by the cleanup pass
  } counts;
  Agreement agreement;  // of the views; contradicted ones did not count
};

// What the labels are made from.
struct LiftingInput {
  const Gaussians& gaussians;           // scene space, file order
  const std::vector<Camera>& cameras;   // [views]
  const std::vector<ViewMasks>& views;  // [views] the same views in the same order
  const Inventory& inventory;           // every object has a residual row
  RunSpecification::Lifting::Occlusion occlusion = RunSpecification::Lifting::Occlusion::none;
};

// The result does not depend on the number of threads.
//
// Objects first: b_io sums the support of object o's masks over the views of Omega_i, plus the area tie-break. A
// Gaussian is ambiguous when its margin (best - second)/best is below 0.18 or when nothing but the tie-break supports
// it; it then takes the vote of the reliable Gaussians (margin from 0.30) among its 12 nearest, all at once. Parts
// then compare within the object only, with the votes of the 16 nearest of that object. What nothing supports and no
// reliable neighbour decides is residual; the cleanup pass hands each row the nearest of the residual Gaussians whose
// nearest labelled Gaussian has that row, up to the rescue target.
//
// With the depth test, views that do not see a Gaussian leave Omega_i (splat/visibility.h), and so do views without a
// mask and those that contradict the others. A Gaussian that no view sees takes the vote of the reliable Gaussians that
// are nearest in place and colour (12 for objects, 16 for parts).
Labels assign_rows(const LiftingInput& input);

// min(candidates, max(64, round(0.003 N_G))), round half away from zero.
long rescue_target(long candidates, long gaussians);

// Index of object o's residual row, -1 when it has none.
int residual_row_of(const Inventory& inventory, int o);

}  // namespace physmas::lift

#endif
