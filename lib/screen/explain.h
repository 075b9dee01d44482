// A screen record as a table that a person can read.
#ifndef PHYSMAS_SCREEN_EXPLAIN_H
#define PHYSMAS_SCREEN_EXPLAIN_H

#include <string>

#include "records/screen.h"

namespace physmas::screen {

// Candidates by rank with their score terms, then every gate with its measured value and limit, then the audit.
std::string explain(const ScreenRecord& record);

}  // namespace physmas::screen

#endif
