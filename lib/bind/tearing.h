// Rows that came apart: the grid lets go of what is two cells away, and nothing else in a run says so.
#ifndef PHYSMAS_BIND_TEARING_H
#define PHYSMAS_BIND_TEARING_H

#include <string>
#include <vector>

#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"

namespace physmas::bind {

// From this share of the bonds within a row on it is torn: less is the fringe of a sparse capture. From that of those
// between two rows on, one comes off the other: what merely slides keeps most.
constexpr double kTornShare = 0.05, kOffShare = 0.2;

// x: [N] positions at the last frame, m. A bond is a particle and one of its six nearest of the same object at rest
// within a cell and a half, where neither of them is of Sand or Snow, which part by nature. It is broken when both are
// more than two cells and three times their distance at rest apart. In the candidate's order of rows, each before what
// it comes off from.
std::vector<TornRow> torn_rows(const Candidate& candidate, const mpm::Problem& problem,
                               const std::vector<mpm::Vec3d>& x);

// "cake/icing comes apart (37 % of …", "cake/icing comes off cake/base (…".
std::string torn_line(const TornRow& row);

}  // namespace physmas::bind

#endif
