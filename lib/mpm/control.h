// What the scheduled actions ask of a particle in one substep.
#ifndef PHYSMAS_MPM_CONTROL_H
#define PHYSMAS_MPM_CONTROL_H

#include "mpm/mat3.h"

namespace physmas::mpm {

// An enforced particle moves with `velocity`, presents that velocity to the grid and does not deform: its own motion is
// the boundary condition. A particle that is not enforced gets `change` added to its velocity before P2G, which is a
// force mass × change / dt.
struct Control {
  bool enforce = false;
  Vec3d velocity = {0, 0, 0};  // m/s
  Vec3d change = {0, 0, 0};    // m/s in this substep

  bool idle() const { return !enforce && change.x == 0 && change.y == 0 && change.z == 0; }
};

// Whether a substep that begins at `time` lies in [start, end) [s]. Substep times are sums of rounded numbers, so a
// millionth of a substep decides ties.
inline bool covers(double start, double end, double time, double dt) {
  return time >= start - 1e-6 * dt && time < end - 1e-6 * dt;
}

}  // namespace physmas::mpm

#endif
