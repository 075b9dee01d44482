// Where the particles of a register are: their stencils in a block (blocks.h) and their weights.
#ifndef PHYSMAS_MPM_CPU_PLACE_H
#define PHYSMAS_MPM_CPU_PLACE_H

#include "mpm/cpu/blocks.h"
#include "mpm/math/lanes.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm {

// Quadratic B-splines (Steffen et al. 2008): three nodes per axis.
template <class V>
struct Place {
  Vec3<V> to_center;  // from the particle to the centre node [cells]
  V weight[3][3];     // per axis
};

// The lowest node of the stencils of particles at x [cells from the block's first node], counted from that node. It is
// held inside the block's reach, so that no number whatsoever can lead a transfer outside it; where that bites, the
// solver's speed check ends the run.
template <class V>
PHYSMAS_INLINE Vec3<V> base_of(const Vec3<V>& x) {
  using T = Scalar<V>;
  Vec3<V> base;
  for (int axis = 0; axis < 3; ++axis) {
    base[axis] = at_most(at_least(round_down(x[axis] - T(0.5)), V(T(-1))), V(T(kBlock)));
  }
  return base;
}

template <class V>
PHYSMAS_INLINE Place<V> place_of(const Vec3<V>& x, const Vec3<V>& base) {
  using T = Scalar<V>;
  Place<V> at;
  for (int axis = 0; axis < 3; ++axis) {
    const V f = x[axis] - base[axis];
    const V l = T(1.5) - f, r = f - T(0.5);
    V* const w = at.weight[axis];
    w[0] = T(0.5) * l * l, w[2] = T(0.5) * r * r;
    w[1] = T(1) - w[0] - w[2];
    at.to_center[axis] = T(1) - f;
  }
  return at;
}

// Whether the stencils do not begin where `at` was taken to begin.
template <class V>
PHYSMAS_INLINE auto strayed(const Place<V>& at) {
  using T = Scalar<V>;
  const V half(T(0.5));
  const Vec3<V>& d = at.to_center;
  return !(absolute(d.x) <= half && absolute(d.y) <= half && absolute(d.z) <= half);
}

}  // namespace physmas::mpm

#endif
