// The study with one material per object: what methods do that give every object a single profile.
#ifndef PHYSMAS_CANDIDATE_ONE_MATERIAL_H
#define PHYSMAS_CANDIDATE_ONE_MATERIAL_H

#include <vector>

#include "candidate/transforms.h"

namespace physmas::candidate {

// Every row of an object, its residual row included, gets label, posterior and continuous values of the object's
// semantic row with the largest volume (the first on ties); an object without one is left alone. volume: of each row's
// particles at rest, [inventory.rows], solver units cubed.
void give_one_material(Evidence& evidence, const Inventory& inventory, const std::vector<double>& volume);

// A row that is stiffer than supports are simulated (1e7 Pa) gets the values of a support: without supports nothing
// else would keep a stone or metal object from diverging.
void bound_stiffness(Configuration& configuration);

// Whether the rows of every object have the same branch, E, nu and rho.
bool has_one_material(const Inventory& inventory, const Configuration& configuration);

}  // namespace physmas::candidate

#endif
