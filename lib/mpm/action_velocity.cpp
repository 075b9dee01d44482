#include "mpm/action_velocity.h"

#include <algorithm>

namespace physmas::mpm {

std::vector<int> particles_of_rows(const std::vector<int>& rows, const Particles& rest) {
  std::vector<int> found;
  for (size_t i = 0; i < rest.size(); ++i) {
    if (std::find(rows.begin(), rows.end(), rest.row[i]) != rows.end()) found.push_back(static_cast<int>(i));
  }
  return found;
}

std::vector<int> select_particles(const Translation& action, const Particles& rest) {
  return particles_of_rows(action.rows, rest);
}

std::vector<int> select_particles(const TopPress& action, const Particles& rest) {
  const std::vector<int> candidates = particles_of_rows(action.rows, rest);
  const Vec3d up = (1 / norm(action.up)) * action.up;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const int i : candidates) {
    const double height = dot(up, rest.position[i]);
    low = std::min(low, height);
    high = std::max(high, height);
  }
  const double border = high - action.slab_fraction * (high - low);
  std::vector<int> slab;
  for (const int i : candidates) {
    if (dot(up, rest.position[i]) >= border) slab.push_back(i);
  }
  return slab;
}

void add_control(const Translation& action, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  control.enforce = true;
  control.velocity = action.velocity;
}

void add_control(const TopPress& action, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  control.enforce = true;
  control.velocity = action.velocity;
}

}  // namespace physmas::mpm
