// Which rows are one body to the solver: those of an object.
#ifndef PHYSMAS_BIND_CONTACT_H
#define PHYSMAS_BIND_CONTACT_H

#include "mpm/body_contact.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::bind {

// Empty bodies where objects stick or only one has particles. Objects are counted in the order of the state's rows;
// from the last that the solver has a field for on (mpm::kMostBodies), they share it.
// Per row of the state: which object it is a part of, counted from 0.
std::vector<int> bind_objects(const State& state);

mpm::BodyContact bind_contact(const State& state, const RunSpecification::Contact& contact);

}  // namespace physmas::bind

#endif
