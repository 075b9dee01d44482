// What the scheduled actions ask of a particle in one substep.
#ifndef PHYSMAS_MPM_ACTION_CONTROL_H
#define PHYSMAS_MPM_ACTION_CONTROL_H

#include <cmath>
#include <limits>

#include "base/constants.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm {

// Every action compiles to this: an affine velocity field, how strongly particles follow it, and a force.
//
// The field is v*(x) = velocity + gradient (x − center), scaled down to `speed_limit` where it is faster. Weights act
// on the difference between the field and the particle's own motion, with one value along `axis` and one across it:
//
// - `blend` is the share by which velocity and affine state move to the field before P2G. Where it is 1 the motion is
//   enforced: G2P is overruled as well, so the particle moves with exactly the field, and deforms with its gradient.
// - `position` is the share by which the particle's place (and its F with it) follows the field instead of its own
//   velocity after G2P: the bounded position increment. Its speed is at most position × speed_limit.
//
// A `brake` holds back only what overtakes the field: on a particle that is not faster than v* in the direction of v*,
// its weights are 0. A field that shrinks back with it lets stored energy out at its own pace, and leaves alone what
// stays behind.
//
// `change` is added to the velocity before P2G, which is a force mass × change / dt.
struct Control {
  struct Weight {
    double along = 0, across = 0;  // 0..1
  };
  Vec3d velocity = {0, 0, 0};                                    // m/s at `center`
  Mat3d gradient = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};          // 1/s
  Vec3d center = {0, 0, 0};                                      // m
  double speed_limit = std::numeric_limits<double>::infinity();  // m/s; finite wherever `gradient` is not zero
  Vec3d axis = {0, 0, 1};                                        // unit
  Weight blend, position;
  bool brake = false;
  Vec3d change = {0, 0, 0};  // m/s in this substep

  bool follows() const { return blend.along > 0 || blend.across > 0 || position.along > 0 || position.across > 0; }
  bool enforces() const { return blend.along == 1 || blend.across == 1; }
  bool idle() const { return !follows() && change.x == 0 && change.y == 0 && change.z == 0; }
  // The fastest that the field is anywhere [m/s].
  double top_speed() const {
    return squared_norm(gradient) == 0 ? std::fmin(speed_limit, norm(velocity)) : speed_limit;
  }
};

// Moves at `velocity`, whatever else acts.
inline void enforce(const Vec3d& velocity, Control& control) {
  const Vec3d change = control.change;
  control = {};
  control.velocity = velocity;
  control.blend = {1, 1};
  control.change = change;
}

// One field acts on a particle at a time: an enforced one wins over a blended one, and the later over the earlier.
inline void follow(const Control& field, Control& control) {
  if (control.enforces() && !control.brake && !field.enforces()) return;
  const Vec3d change = control.change;
  control = field;
  control.change = change;
}

// Whether a substep that begins at `time` lies in [start, end) [s]. Substep times are sums of rounded numbers, so a
// millionth of a substep decides ties.
inline bool covers(double start, double end, double time, double dt) {
  return time >= start - 1e-6 * dt && time < end - 1e-6 * dt;
}

// Lets go of what nothing else moves: the field is enforced as a brake.
inline void give_way(const Control& field, Control& control) {
  if (control.follows()) return;
  const Vec3d change = control.change;
  control = field;
  control.brake = true;
  control.change = change;
}

// The share of its way, 0..1, that a hand has gone back at `time` over [start, start + duration). It is at rest at both
// ends, so that what leans on it is neither let go with a jerk nor thrown; half way it is twice as fast as on average.
inline double retreat_way(double start, double duration, double time) {
  const double s = std::fmin(1.0, std::fmax(0.0, (time - start) / duration));
  return s - std::sin(2 * kPi * s) / (2 * kPi);
}

// A slab that was moved by `way` [m] until `end` goes back over [end, end + release), held back along that way only.
inline void let_back(const Vec3d& way, double end, double release, double time, double dt, Control& control) {
  const double length = norm(way);
  if (!(release > 0) || !(length > 0) || !covers(end, end + release, time, dt)) return;
  Control field;
  field.axis = (1 / length) * way;
  const double share = retreat_way(end, release, time + dt) - retreat_way(end, release, time);
  field.velocity = (-share / dt) * way;
  field.blend.along = 1;
  give_way(field, control);
}

// The blend weight of a substep that leaves exp(−dt/time) of a difference: shorter substeps blend as much per second.
inline double blend_weight(double dt, double time) {
  return -std::expm1(-dt / time);
}

}  // namespace physmas::mpm

#endif
