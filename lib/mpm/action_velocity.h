// Actions that enforce a constant velocity on particles (paper, Table "actions": translation, top_press).
#ifndef PHYSMAS_MPM_ACTION_VELOCITY_H
#define PHYSMAS_MPM_ACTION_VELOCITY_H

#include <vector>

#include "mpm/control.h"
#include "mpm/state.h"

namespace physmas::mpm {

// Every particle of the rows moves with `velocity` during [start, end).
struct Translation {
  std::vector<int> rows;
  Vec3d velocity = {0, 0, 0};  // m/s
  double start = 0, end = 0;   // s
};

// The slab of the rows that is nearest the top at rest moves with `velocity` during [start, end).
struct TopPress {
  std::vector<int> rows;
  Vec3d velocity = {0, 0, 0};   // m/s, usually against `up`
  Vec3d up = {0, 0, 1};         // any length > 0
  double slab_fraction = 0.15;  // slab thickness over the rows' rest extent along up, 0..1
  double start = 0, end = 0;    // s
};

// Indices of the particles that an action moves, ascending; chosen at rest, once.
std::vector<int> select_particles(const Translation& action, const Particles& rest);
std::vector<int> select_particles(const TopPress& action, const Particles& rest);

// Adds what the action does in the substep [time, time + dt) to `control`. The later of two enforced velocities wins.
void add_control(const Translation& action, double time, double dt, Control& control);
void add_control(const TopPress& action, double time, double dt, Control& control);

// Indices of the particles of any of `rows`, ascending.
std::vector<int> particles_of_rows(const std::vector<int>& rows, const Particles& rest);

}  // namespace physmas::mpm

#endif
