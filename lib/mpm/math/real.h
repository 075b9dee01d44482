// The operations that the solver's formulas are written with. They exist for float, double and SIMD lanes alike; a GPU
// compiler sees plain numbers only.
#ifndef PHYSMAS_MPM_MATH_REAL_H
#define PHYSMAS_MPM_MATH_REAL_H

#include "mpm/math/scalar.h"
#ifndef __CUDACC__
#include "mpm/math/lanes.h"
#endif

#endif
