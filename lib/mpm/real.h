// The operations that the solver's formulas are written with. They exist for float, double and SIMD lanes alike; a GPU
// compiler sees plain numbers only.
#ifndef PHYSMAS_MPM_REAL_H
#define PHYSMAS_MPM_REAL_H

#include "mpm/scalar.h"
#ifndef __CUDACC__
#include "mpm/lanes.h"
#endif

namespace physmas::mpm {

// NaN in the first argument gives the second: a bad number never survives a clamp.
template <class T>
PHYSMAS_INLINE T at_least(T x, T low) {
  return select(x > low, x, low);
}
template <class T>
PHYSMAS_INLINE T at_most(T x, T high) {
  return select(x < high, x, high);
}

}  // namespace physmas::mpm

#endif
