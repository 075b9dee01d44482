// The fixed problems of the accuracy study.
#ifndef PHYSMAS_STUDIES_ACCURACY_CASES_H
#define PHYSMAS_STUDIES_ACCURACY_CASES_H

#include <string>
#include <vector>

#include "mpm/simulation.h"

namespace physmas::studies {

struct AccuracyCase {
  std::string name;      // jelly-drop
  std::string text;      // one sentence
  mpm::Problem problem;  // the grid's n is set by the study
  double size = 0;       // m: longest edge of an object, which errors are normalised by
  double duration = 0;   // s
};

// Jelly drop, plasticine press, sand collapse, two-object impact, stiff support under a soft body. spacing [m]: of the
// particles, on a lattice that is not aligned with any grid.
std::vector<AccuracyCase> accuracy_cases(double spacing);

// Every particle replaced by eight, a quarter of `spacing` away along each axis, with an eighth of its volume. Particle
// i becomes 8 i … 8 i + 7, whose mean is where particle i is.
mpm::Problem subdivide(const mpm::Problem& problem, double spacing);

}  // namespace physmas::studies

#endif
