// Where a scene lies in the solver's cube.
#ifndef PHYSMAS_SCENE_PLACEMENT_H
#define PHYSMAS_SCENE_PLACEMENT_H

#include "records/run_specification.h"
#include "records/state.h"
#include "scene/gaussians.h"

namespace physmas {

// N(x) = s x + d: the bounding box of all means gets `placement.extent` as its longest side (s = 1 for a single point)
// and `placement.center` as its centre. gaussians: at least one.
SolverMap solver_map(const Gaussians& gaussians, const RunSpecification& run);

// Range of u . N(x) over all means, u the up axis: the scene's lowest and highest point, solver units.
struct Heights {
  double lowest = 0, highest = 0;
};
Heights heights_of(const Gaussians& gaussians, const RunSpecification& run);

// Range of u . x between the walls of the solver's cube.
Heights wall_heights(const RunSpecification& run);

// A plane collider across the up axis at that height (u . x, solver units), free above.
RunSpecification::Collider floor_at(double height, const RunSpecification& run);

}  // namespace physmas

#endif
