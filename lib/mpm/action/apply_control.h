// Applies the controls of a substep to one register of particles. Called for registers with a controlled lane only.
#ifndef PHYSMAS_MPM_ACTION_APPLY_CONTROL_H
#define PHYSMAS_MPM_ACTION_APPLY_CONTROL_H

#include <cstdint>
#include <vector>

#include "mpm/action/control.h"
#include "mpm/math/lanes.h"

namespace physmas::mpm {

// A control per group, group 0 idle; in double precision, because it is turned into a block's frame first.
struct ControlTable {
  bool active = false;
  std::vector<Control> group;
};

// The controls of W lanes in a block's frame, where positions x are in cells from the block's first node. The field is
// at + slope x, so its far-away centre is subtracted in double precision, once per register, and never in the lanes.
template <class T>
struct LaneControls {
  using V = Lanes<T>;
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

// A control in the order of LaneControls. origin: the block's first node [m].
template <class T>
void write_numbers(const Control& c, const Vec3d& origin, T* out) {
  const Vec3d at = c.velocity + c.gradient * (origin - c.center);
  for (int a = 0; a < 3; ++a) *out++ = T(at[a]);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) *out++ = T(c.gradient[a][b]);
  }
  *out++ = T(c.speed_limit);
  for (int a = 0; a < 3; ++a) *out++ = T(c.axis[a]);
  for (const double weight : {c.blend.along, c.blend.across, c.position.along, c.position.across}) *out++ = T(weight);
  for (int a = 0; a < 3; ++a) *out++ = T(c.change[a]);
  *out++ = T(c.brake ? 1 : 0);
}

// next: gives the numbers one after the other, all lanes.
template <class T, class Next>
PHYSMAS_INLINE LaneControls<T> read_numbers(double dx, const Next& next) {
  LaneControls<T> c;
  for (int a = 0; a < 3; ++a) c.at[a] = next();
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) c.gradient[a][b] = next();
  }
  c.slope = Lanes<T>(T(dx)) * c.gradient;
  c.speed_limit = next();
  for (int a = 0; a < 3; ++a) c.axis[a] = next();
  c.along = next(), c.across = next();
  c.position_along = next(), c.position_across = next();
  for (int a = 0; a < 3; ++a) c.change[a] = next();
  c.brake = next();
  return c;
}

}  // namespace control_detail

// Lanes of several groups. group: the control group of every lane, [kLanes<T>]; 0 for an empty lane. origin: the
// block's first node [m].
template <class T>
LaneControls<T> load_controls(const ControlTable& table, const std::uint16_t* group, const Vec3d& origin, double dx) {
  constexpr int W = kLanes<T>, kNumbers = control_detail::kNumbers;
  alignas(64) T lanes[kNumbers][W];
  T numbers[kNumbers];
  for (int l = 0; l < W; ++l) {
    if (l == 0 || group[l] != group[l - 1]) {
      control_detail::write_numbers(table.group[group[l]], origin, numbers);
    }
    for (int k = 0; k < kNumbers; ++k) lanes[k][l] = numbers[k];
  }
  int k = 0;
  return control_detail::read_numbers<T>(dx, [&] { return Lanes<T>(lanes[k++], stdx::vector_aligned); });
}

// One control for all lanes that are `held`; nothing happens to the others.
template <class T>
LaneControls<T> load_controls(const Control& control, LaneBits held, const Vec3d& origin, double dx) {
  using V = Lanes<T>;
  T numbers[control_detail::kNumbers];
  control_detail::write_numbers(control, origin, numbers);
  int k = 0;
  LaneControls<T> c = control_detail::read_numbers<T>(dx, [&] { return V(numbers[k++]); });
  if (held == kAllLanes<T>) return c;
  const auto mask = lane_mask<T>(held);
  for (V* lanes : {&c.along, &c.across, &c.position_along, &c.position_across, &c.change.x, &c.change.y, &c.change.z}) {
    *lanes = select(mask, *lanes, V(T(0)));
  }
  return c;
}

namespace control_detail {

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
template <class T, class V = Lanes<T>>
PHYSMAS_INLINE Field<V> field_at(const LaneControls<T>& c, const Vec3<V>& x) {
  const Vec3<V> free = c.at + c.slope * x;
  const V squared = dot(free, free);
  const V scale = select(squared > c.speed_limit * c.speed_limit, c.speed_limit / square_root(squared), V(1));
  return {scale * free, scale * c.gradient};
}

// Of a weight, what holds for a particle of velocity v.
template <class T, class V = Lanes<T>>
PHYSMAS_INLINE V held_back(const LaneControls<T>& c, const Field<V>& field, const Vec3<V>& v, const V& weight) {
  return select(c.brake > V(0) && dot(v, field.velocity) <= dot(field.velocity, field.velocity), V(0), weight);
}

}  // namespace control_detail

// Before P2G: velocity and affine state move to the field by the blend weights, then the force's share is added.
// Returns the gain of kinetic energy, never negative [J], summed over the lanes.
template <class T>
double blend_controls(const LaneControls<T>& c, const Vec3<Lanes<T>>& x, const Lanes<T>& mass, Vec3<Lanes<T>>& v,
                      Mat3<Lanes<T>>& C) {
  using V = Lanes<T>;
  const auto field = control_detail::field_at(c, x);
  const V before = dot(v, v);
  const V along = control_detail::held_back(c, field, v, c.along);
  const V across = control_detail::held_back(c, field, v, c.across);
  v = control_detail::blended(v, field.velocity, c.axis, along, across) + c.change;
  C = control_detail::blended(C, field.gradient, c.axis, along, across);
  const V gain = V(T(0.5)) * mass * (dot(v, v) - before);
  return double(stdx::reduce(at_least(gain, V(0))));
}

// What enforced motion and position increments do to the particles of a register after G2P.
template <class V>
struct ForcedMotion {
  Vec3<V> increment;           // m/s, to be added to v where positions advance
  Mat3<V> increment_gradient;  // 1/s, to be added to C where F advances
  Mat3<V> forced;              // 1/s, the whole difference between the gradient that F advances with and G2P's
};

// After G2P: v and C become the field's where the motion is enforced; what else the place moves by is returned. `work`
// gets the gain of kinetic energy, never negative [J].
template <class T>
ForcedMotion<Lanes<T>> force_motion(const LaneControls<T>& c, const Vec3<Lanes<T>>& x, const Lanes<T>& mass,
                                    Vec3<Lanes<T>>& v, Mat3<Lanes<T>>& C, double& work) {
  using V = Lanes<T>;
  using control_detail::blended;
  using control_detail::held_back;
  const auto field = control_detail::field_at(c, x);
  const V before = dot(v, v);
  const Mat3<V> free = C;
  const V along = held_back(c, field, v, select(c.along >= V(1), V(1), V(0)));
  const V across = held_back(c, field, v, select(c.across >= V(1), V(1), V(0)));
  v = blended(v, field.velocity, c.axis, along, across);
  C = blended(C, field.gradient, c.axis, along, across);
  const V gain = V(T(0.5)) * mass * (dot(v, v) - before);
  work += double(stdx::reduce(at_least(gain, V(0))));

  ForcedMotion<V> out;
  out.increment = blended(v, field.velocity, c.axis, c.position_along, c.position_across) - v;
  const V bound = at_least(c.position_along, c.position_across) * c.speed_limit;
  const V size = dot(out.increment, out.increment);
  const V scale = select(size > bound * bound, bound / square_root(size), V(1));
  out.increment = scale * out.increment;
  out.increment_gradient = scale * (blended(C, field.gradient, c.axis, c.position_along, c.position_across) - C);
  out.forced = C + out.increment_gradient - free;
  return out;
}

// The elastic energy [J] that forced motion puts into the particles in a substep, never negative, summed over the
// lanes: dt V⁰ τ : forced, with τ after the step, which for a convex energy is not less than the true gain.
template <class T>
double elastic_work(const ForcedMotion<Lanes<T>>& motion, const Mat3<Lanes<T>>& tau, const Lanes<T>& volume, T dt) {
  using V = Lanes<T>;
  V power(0);
  for (int a = 0; a < 3; ++a) power += dot(tau[a], motion.forced[a]);
  return double(stdx::reduce(at_least(V(dt) * volume * power, V(0))));
}

}  // namespace physmas::mpm

#endif
