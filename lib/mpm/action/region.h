// Regions of rows at rest: what the actions select their particles with.
#ifndef PHYSMAS_MPM_ACTION_REGION_H
#define PHYSMAS_MPM_ACTION_REGION_H

#include <vector>

#include "mpm/state.h"

namespace physmas::mpm {

// Indices of the particles of any of `rows`, ascending.
std::vector<int> particles_of_rows(const std::vector<int>& rows, const Particles& rest);

// Smallest and largest coordinate [m] along a direction.
struct Extent {
  double low = 0, high = 0;
  double length() const { return high - low; }
};

// The particles that an action moves, and what it needs to know of the shape that they were selected from.
struct Region {
  std::vector<int> particles;  // indices, ascending
  Extent extent;               // of all of the rows, along the axis of selection
  Vec3d center = {0, 0, 0};    // unweighted mean rest position of `particles` [m]
  double radius = 0;           // largest rest distance of `particles` from the axis through `center` [m]
};

// The part of the rows that lies at one end of them at rest. towards: which end, any length > 0; it is the axis of the
// region. fraction: thickness over the rows' rest extent along `towards`, 0..1; 1 takes all of the rows.
Region select_slab(const std::vector<int>& rows, const Vec3d& towards, double fraction, const Particles& rest);

}  // namespace physmas::mpm

#endif
