// Interior particles: what MPM needs inside objects of which 3DGS knows only the surface (paper, Appendix "Gaussian and
// Filled-Particle Initialization").
#ifndef PHYSMAS_LIFT_FILLING_H
#define PHYSMAS_LIFT_FILLING_H

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "records/run_specification.h"
#include "records/state.h"
#include "scene/gaussians.h"

namespace physmas::lift {

struct Filling {
  std::vector<Eigen::Vector3f> position;  // [N_fill] solver space, object by object
  std::vector<int32_t> object;            // [N_fill] o(q)
  struct Report {
    enum class Verdict { filled, solid, open, none } verdict = Verdict::none;  // none: the object has no Gaussians
    long cells = 0;       // subcells that the object takes up, its interior included
    double solidity = 0;  // share of its inner solver cells that hold a Gaussian already
    double volume = 0;    // cells in solver units cubed
  };
  std::vector<Report> objects;  // [objects]
  double spacing = 0;           // edge of a subcell, solver units
  double kept = 1;              // share of the lattice that the density and the particle limit left
};

// Fills each object's interior with a lattice of per_cell particles per solver cell:
//   1. the object's Gaussians are drawn into subcells (dx over the cube root of per_cell, at least two per dx and axis)
//      as ellipsoids at 1.5 standard deviations, faint ones (opacity below 0.1) left out;
//   2. gaps are closed (dilation and erosion by one subcell) and everything that the outside does not reach is inside;
//   3. as many layers as the bodies reach outwards (median over the object) are taken off the surface; subcells that
//      hold a Gaussian of any object, or that another object takes up, are left out.
// An object is solid, and left as it is, when 95 % of the solver cells that lie wholly inside hold one of its
// Gaussians. An object that encloses nothing is open. The lattice is thinned evenly (along a space-filling curve) to
// the density and to the particles that the Gaussians leave of `max`.
//
// means: N(x) of all Gaussians, solver space. object: [N] labels. The result does not depend on the thread count.
Filling fill_objects(const Gaussians& gaussians, const std::vector<Eigen::Vector3f>& means,
                     const std::vector<int32_t>& object, int objects, const SolverMap& map,
                     const RunSpecification& run);

// V_q^0: volume of the solver cell over the number of particles in it at rest (readings, "Lifting, particles,
// transport"). Cells and length as in `map`. Solver units cubed, all > 0.
std::vector<float> rest_volumes(const std::vector<Eigen::Vector3f>& position, const SolverMap& map);

}  // namespace physmas::lift

#endif
