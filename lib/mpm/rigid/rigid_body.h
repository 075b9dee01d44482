// The motion of one rigid body.
#ifndef PHYSMAS_MPM_RIGID_RIGID_BODY_H
#define PHYSMAS_MPM_RIGID_RIGID_BODY_H

#include "mpm/rigid/node_moments.h"
#include "mpm/rigid/rigid_setup.h"
#include "mpm/state.h"

namespace physmas::mpm {

// The rotation by the vector `turn`, its length the angle [rad] (Rodrigues).
Mat3d rotation_by(const Vec3d& turn);

struct RigidBody {
  Vec3d center = {0, 0, 0};             // m
  Mat3d rotation = identity<double>();  // of the shape at rest
  Twist motion;
  Vec3d angular_momentum = {0, 0, 0};  // kg m^2/s, about the centre

  Mat3d inertia(const RigidBodyRest& rest) const { return times_transposed(rotation * rest.inertia, rotation); }
  // Takes over motion, and the angular momentum with it.
  void set_motion(const RigidBodyRest& rest, const Twist& twist);
  // The body that is closest to particles in this state: their centre, the best-fit rotation of the shape at rest,
  // their momentum and angular momentum, of affine fields too. mass: per particle [kg]; dx [m].
  void fit(const RigidBodyRest& rest, const std::vector<Vec3d>& offset, const State& state,
           const std::vector<double>& mass, double dx);
  // Moves by a step of dt [s] at constant momentum and angular momentum: rotation by the implicit midpoint's angular
  // velocity, predicted once.
  void move(const RigidBodyRest& rest, double dt);
};

}  // namespace physmas::mpm

#endif
