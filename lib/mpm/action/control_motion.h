// What a control does to the velocity and the affine state of particles: for numbers and for SIMD lanes, on the CPU and
// on a GPU.
#ifndef PHYSMAS_MPM_ACTION_CONTROL_MOTION_H
#define PHYSMAS_MPM_ACTION_CONTROL_MOTION_H

#include "mpm/action/control.h"

namespace physmas::mpm {

// A control in a block's frame, where positions x are in cells from the block's first node. The field is at + slope x,
// so its far-away centre is subtracted in double precision, once, and never in V.
template <class V>
struct LocalControl {
  Vec3<V> at;     // m/s at the block's first node
  Mat3<V> slope;  // m/s per cell
  Mat3<V> gradient;
  V speed_limit;
  Vec3<V> axis;
  V along, across;                    // blend
  V position_along, position_across;  // position increment
  Vec3<V> change;
  V brake;  // 1: the weights hold for particles that are faster than the field; 0: for all
};

namespace control_detail {

constexpr int kNumbers = 3 + 9 + 1 + 3 + 4 + 3 + 1;

// A control in the order of LocalControl. origin: the block's first node [m].
template <class T>
PHYSMAS_HOST_DEVICE inline void write_numbers(const Control& c, const Vec3d& origin, T* out) {
  const Vec3d at = c.velocity + c.gradient * (origin - c.center);
  for (int a = 0; a < 3; ++a) *out++ = T(at[a]);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) *out++ = T(c.gradient[a][b]);
  }
  *out++ = T(c.speed_limit);
  for (int a = 0; a < 3; ++a) *out++ = T(c.axis[a]);
  *out++ = T(c.blend.along), *out++ = T(c.blend.across);
  *out++ = T(c.position.along), *out++ = T(c.position.across);
  for (int a = 0; a < 3; ++a) *out++ = T(c.change[a]);
  *out++ = T(c.brake ? 1 : 0);
}

// next: gives the numbers one after the other.
template <class V, class Next>
PHYSMAS_INLINE LocalControl<V> read_numbers(double dx, const Next& next) {
  LocalControl<V> c;
  for (int a = 0; a < 3; ++a) c.at[a] = next();
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) c.gradient[a][b] = next();
  }
  c.slope = V(Scalar<V>(dx)) * c.gradient;
  c.speed_limit = next();
  for (int a = 0; a < 3; ++a) c.axis[a] = next();
  c.along = next(), c.across = next();
  c.position_along = next(), c.position_across = next();
  for (int a = 0; a < 3; ++a) c.change[a] = next();
  c.brake = next();
  return c;
}

// v moved towards `target` by the weights along and across `axis`. Weights 0 and 1 are exact.
template <class V>
PHYSMAS_INLINE Vec3<V> blended(const Vec3<V>& v, const Vec3<V>& target, const Vec3<V>& axis, const V& along,
                               const V& across) {
  const V extra = (along - across) * dot(axis, target - v);
  return (V(1) - across) * v + across * target + extra * axis;
}

template <class V>
PHYSMAS_INLINE Mat3<V> blended(const Mat3<V>& C, const Mat3<V>& target, const Vec3<V>& axis, const V& along,
                               const V& across) {
  const Vec3<V> extra = (along - across) * (transpose(target - C) * axis);
  Mat3<V> out = (V(1) - across) * C + across * target;
  for (int a = 0; a < 3; ++a) out[a] = out[a] + axis[a] * extra;
  return out;
}

template <class V>
struct Field {
  Vec3<V> velocity;
  Mat3<V> gradient;
};

// The field at x. Where it is cut to the speed limit its gradient is cut alike.
template <class V>
PHYSMAS_INLINE Field<V> field_at(const LocalControl<V>& c, const Vec3<V>& x) {
  const Vec3<V> free = c.at + c.slope * x;
  const V squared = dot(free, free);
  const V scale = select(squared > c.speed_limit * c.speed_limit, c.speed_limit / square_root(squared), V(1));
  return {scale * free, scale * c.gradient};
}

// Of a weight, what holds for a particle of velocity v.
template <class V>
PHYSMAS_INLINE V held_back(const LocalControl<V>& c, const Field<V>& field, const Vec3<V>& v, const V& weight) {
  return select(c.brake > V(0) && dot(v, field.velocity) <= dot(field.velocity, field.velocity), V(0), weight);
}

}  // namespace control_detail

// A control in the frame of the block whose first node is at `origin` [m].
template <class T>
PHYSMAS_HOST_DEVICE inline LocalControl<T> localise(const Control& control, const Vec3d& origin, double dx) {
  T numbers[control_detail::kNumbers];
  control_detail::write_numbers(control, origin, numbers);
  int k = 0;
  return control_detail::read_numbers<T>(dx, [&] { return numbers[k++]; });
}

// Before P2G: velocity and affine state move to the field by the blend weights, then the force's share is added.
// Returns the gain of kinetic energy, never negative [J].
template <class V>
PHYSMAS_INLINE V blend_motion(const LocalControl<V>& c, const Vec3<V>& x, const V& mass, Vec3<V>& v, Mat3<V>& C) {
  using T = Scalar<V>;
  const auto field = control_detail::field_at(c, x);
  const V before = dot(v, v);
  const V along = control_detail::held_back(c, field, v, c.along);
  const V across = control_detail::held_back(c, field, v, c.across);
  v = control_detail::blended(v, field.velocity, c.axis, along, across) + c.change;
  C = control_detail::blended(C, field.gradient, c.axis, along, across);
  const V gain = V(T(0.5)) * mass * (dot(v, v) - before);
  return at_least(gain, V(0));
}

// What enforced motion and position increments do to particles after G2P.
template <class V>
struct ForcedMotion {
  Vec3<V> increment;           // m/s, to be added to v where positions advance
  Mat3<V> increment_gradient;  // 1/s, to be added to C where F advances
  Mat3<V> forced;              // 1/s, the whole difference between the gradient that F advances with and G2P's
  V gain;                      // J of kinetic energy, never negative
};

// After G2P: v and C become the field's where the motion is enforced; what else the place moves by is returned.
template <class V>
PHYSMAS_INLINE ForcedMotion<V> enforce_motion(const LocalControl<V>& c, const Vec3<V>& x, const V& mass, Vec3<V>& v,
                                              Mat3<V>& C) {
  using T = Scalar<V>;
  using control_detail::blended;
  using control_detail::held_back;
  const auto field = control_detail::field_at(c, x);
  const V before = dot(v, v);
  const Mat3<V> free = C;
  const V along = held_back(c, field, v, select(c.along >= V(1), V(1), V(0)));
  const V across = held_back(c, field, v, select(c.across >= V(1), V(1), V(0)));
  v = blended(v, field.velocity, c.axis, along, across);
  C = blended(C, field.gradient, c.axis, along, across);
  ForcedMotion<V> out;
  out.gain = at_least(V(T(0.5)) * mass * (dot(v, v) - before), V(0));
  out.increment = blended(v, field.velocity, c.axis, c.position_along, c.position_across) - v;
  const V bound = at_least(c.position_along, c.position_across) * c.speed_limit;
  const V size = dot(out.increment, out.increment);
  const V scale = select(size > bound * bound, bound / square_root(size), V(1));
  out.increment = scale * out.increment;
  out.increment_gradient = scale * (blended(C, field.gradient, c.axis, c.position_along, c.position_across) - C);
  out.forced = C + out.increment_gradient - free;
  return out;
}

// The elastic energy [J] that forced motion puts into a particle in a substep, never negative: dt V⁰ τ : forced, with τ
// after the step, which for a convex energy is not less than the true gain.
template <class V>
PHYSMAS_INLINE V elastic_gain(const ForcedMotion<V>& motion, const Mat3<V>& tau, const V& volume, const V& dt) {
  V power(0);
  for (int a = 0; a < 3; ++a) power += dot(tau[a], motion.forced[a]);
  return at_least(dt * volume * power, V(0));
}

}  // namespace physmas::mpm

#endif
