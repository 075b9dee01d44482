// How a set of particles has moved between two moments: what an action achieved is measured with these.
#ifndef PHYSMAS_MPM_ACTION_REGION_MOTION_H
#define PHYSMAS_MPM_ACTION_REGION_MOTION_H

#include <vector>

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// The places of the same particles at one moment [m], in the same order throughout; none of the functions below may
// get an empty list. Particles count alike. Axes are unit vectors.
using Places = std::vector<Vec3d>;

Vec3d center_of(const Places& places);

// Mean distance between the places of a particle [m].
double mean_distance(const Places& from, const Places& to);

// The angle [rad, −π..π] about `axis`, by the right-hand rule, that turns the offsets from the centre, seen along the
// axis, onto the later ones best in the least-squares sense. 0 where nothing lies off the axis.
double turn_about(const Vec3d& axis, const Places& from, const Places& to);

// By what factor coordinates along `axis` have grown: the slope of the least-squares line of the later over the earlier
// ones. 1 where the earlier ones are all the same.
double stretch_along(const Vec3d& axis, const Places& from, const Places& to);

// Root mean square distance from the line along `axis` through the centre [m].
double radius_about(const Vec3d& axis, const Places& places);

}  // namespace physmas::mpm

#endif
