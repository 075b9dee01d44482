// Labels without islands: small pieces of a row that hang apart from it.
#ifndef PHYSMAS_LIFT_ISLANDS_H
#define PHYSMAS_LIFT_ISLANDS_H

#include <string>
#include <vector>

#include "lift/assignment.h"
#include "records/inventory.h"
#include "records/provenance.h"
#include "scene/gaussians.h"

namespace physmas::lift {

// A piece smaller than this share of the largest piece of its row is an island. Pieces of like size (wheels, candles,
// buttons) are what their row consists of.
constexpr double kIslandShare = 0.02;

struct Islands {
  long given_pieces = 0, given = 0;  // pieces, and their Gaussians
  long apart_pieces = 0, apart = 0;  // that touch nothing
  std::vector<Omission> omitted;     // a line per row that gave some away or keeps some apart
};

// Gives every island to the row that it touches more closely than its own: that of the most of its Gaussians whose
// nearest Gaussian of a piece that is no island is within reach. Residual rows consist of leftovers: they neither give
// nor take. An island that touches nothing keeps its row. The confidence of what was given away is capped as that of
// votes. All at once, in one pass; the result does not depend on the thread count.
//
// The reach is `cell` [scene units], the edge of the solver's cell, across which particles feel each other, or twice
// the median distance between neighbours of the row where the scene is sparser. Pieces are told apart on a lattice of
// half of that: what lies in the same cell or in two that touch hangs together.
Islands join_islands(const Gaussians& gaussians, const Inventory& inventory, double cell, Labels& labels);

}  // namespace physmas::lift

#endif
