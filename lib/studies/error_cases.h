// Cases on which the error estimate is held against a fine reference, beside those of the accuracy study.
#ifndef PHYSMAS_STUDIES_ERROR_CASES_H
#define PHYSMAS_STUDIES_ERROR_CASES_H

#include <vector>

#include "studies/accuracy_cases.h"

namespace physmas::studies {

// spacing [m], as in accuracy_cases. A rolling ball, a cantilever, a tower of three blocks, a snowball that breaks, a
// foam cushion under a ball, a twisted bar.
std::vector<AccuracyCase> further_cases(double spacing);

// Written when the estimate was done, and never used to change it: a block of sand that falls, pressed snow, a thrown
// cross, a slab that tips over.
std::vector<AccuracyCase> held_out_cases(double spacing);

}  // namespace physmas::studies

#endif
