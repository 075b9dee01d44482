#include "mpm/action_impulse.h"

#include <algorithm>

#include "mpm/action_velocity.h"

namespace physmas::mpm {

std::vector<int> select_particles(const Impulse& action, const Particles& rest) {
  return particles_of_rows(action.rows, rest);
}

void add_control(const Impulse& action, double time, double dt, Control& control) {
  const double end = action.end();
  const double covered = std::min(end, time + dt) - std::max(action.start, time);
  if (covered <= 0) return;
  control.change = control.change + (covered / (end - action.start)) * action.velocity_change;
}

}  // namespace physmas::mpm
