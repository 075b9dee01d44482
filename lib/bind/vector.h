// Vectors of the records and of the solver.
#ifndef PHYSMAS_BIND_VECTOR_H
#define PHYSMAS_BIND_VECTOR_H

#include <Eigen/Core>

#include "mpm/math/mat3.h"

namespace physmas::bind {

inline mpm::Vec3d to_mpm(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
inline Eigen::Vector3d from_mpm(const mpm::Vec3d& v) {
  return {v.x, v.y, v.z};
}

}  // namespace physmas::bind

#endif
