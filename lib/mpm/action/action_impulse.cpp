#include "mpm/action/action_impulse.h"

#include <algorithm>

namespace physmas::mpm {

Region select_region(const Impulse& action, const Particles& rest) {
  return select_slab(action.rows, {0, 0, 1}, 1, rest);
}

void add_control(const Impulse& action, const Region&, double time, double dt, Control& control) {
  const double end = action.end();
  const double covered = std::min(end, time + dt) - std::max(action.start, time);
  if (covered <= 0) return;
  control.change = control.change + (covered / (end - action.start)) * action.velocity_change;
}

}  // namespace physmas::mpm
