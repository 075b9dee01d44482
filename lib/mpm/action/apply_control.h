// Applies the controls of a substep to one register of particles. Called for registers with a controlled lane only.
#ifndef PHYSMAS_MPM_ACTION_APPLY_CONTROL_H
#define PHYSMAS_MPM_ACTION_APPLY_CONTROL_H

#include <cstdint>
#include <vector>

#include "mpm/action/control_motion.h"
#include "mpm/math/lanes.h"

namespace physmas::mpm {

// A control per group, group 0 idle; in double precision, because it is turned into a block's frame first.
struct ControlTable {
  bool active = false;
  std::vector<Control> group;
};

// The controls of W lanes.
template <class T>
using LaneControls = LocalControl<Lanes<T>>;

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
  return control_detail::read_numbers<Lanes<T>>(dx, [&] { return Lanes<T>(lanes[k++], stdx::vector_aligned); });
}

// One control for all lanes that are `held`; nothing happens to the others.
template <class T>
LaneControls<T> load_controls(const Control& control, LaneBits held, const Vec3d& origin, double dx) {
  using V = Lanes<T>;
  T numbers[control_detail::kNumbers];
  control_detail::write_numbers(control, origin, numbers);
  int k = 0;
  LaneControls<T> c = control_detail::read_numbers<V>(dx, [&] { return V(numbers[k++]); });
  if (held == kAllLanes<T>) return c;
  const auto mask = lane_mask<T>(held);
  for (V* lanes : {&c.along, &c.across, &c.position_along, &c.position_across, &c.change.x, &c.change.y, &c.change.z}) {
    *lanes = select(mask, *lanes, V(T(0)));
  }
  return c;
}

// The functions of control_motion.h; gains are summed over the lanes.
template <class T>
double blend_controls(const LaneControls<T>& c, const Vec3<Lanes<T>>& x, const Lanes<T>& mass, Vec3<Lanes<T>>& v,
                      Mat3<Lanes<T>>& C) {
  return double(stdx::reduce(blend_motion(c, x, mass, v, C)));
}
template <class T>
ForcedMotion<Lanes<T>> force_motion(const LaneControls<T>& c, const Vec3<Lanes<T>>& x, const Lanes<T>& mass,
                                    Vec3<Lanes<T>>& v, Mat3<Lanes<T>>& C, double& work) {
  const ForcedMotion<Lanes<T>> motion = enforce_motion(c, x, mass, v, C);
  work += double(stdx::reduce(motion.gain));
  return motion;
}
template <class T>
double elastic_work(const ForcedMotion<Lanes<T>>& motion, const Mat3<Lanes<T>>& tau, const Lanes<T>& volume, T dt) {
  return double(stdx::reduce(elastic_gain(motion, tau, volume, Lanes<T>(dt))));
}

}  // namespace physmas::mpm

#endif
