#include "mpm/rigid/rigid_body.h"

#include <cmath>

#include "mpm/math/svd.h"
#include "mpm/rigid/small_solve.h"

namespace physmas::mpm {

Mat3d rotation_by(const Vec3d& turn) {
  const double angle = norm(turn);
  const Mat3d K = cross_matrix(turn);
  // By series where the quotients lose digits.
  const double sine = angle > 1e-4 ? std::sin(angle) / angle : 1 - angle * angle / 6;
  const double half = angle > 1e-4 ? std::sin(angle / 2) / (angle / 2) : 1 - angle * angle / 24;
  return identity<double>() + sine * K + (half * half / 2) * (K * K);
}

void RigidBody::set_motion(const RigidBodyRest& rest, const Twist& twist) {
  motion = twist;
  angular_momentum = inertia(rest) * twist.spin;
}

void RigidBody::fit(const RigidBodyRest& rest, const std::vector<Vec3d>& offset, const State& state,
                    const std::vector<double>& mass, double dx) {
  Vec3d first{0, 0, 0}, momentum{0, 0, 0};
  for (const int i : rest.particles) {
    first = first + mass[i] * (state.x[i] - rest.center);
    momentum = momentum + mass[i] * state.v[i];
  }
  center = rest.center + (1 / rest.mass) * first;
  motion.velocity = (1 / rest.mass) * momentum;
  Mat3d moved = diagonal(0.0, 0.0, 0.0);
  angular_momentum = {0, 0, 0};
  double scale = 0;
  for (const int i : rest.particles) {
    const Vec3d now = state.x[i] - center;
    for (int a = 0; a < 3; ++a) moved[a] = moved[a] + (mass[i] * now[a]) * offset[i];
    scale += mass[i] * dot(offset[i], offset[i]);
    const Mat3d& C = state.C[i];
    const Vec3d curl = {C[2][1] - C[1][2], C[0][2] - C[2][0], C[1][0] - C[0][1]};
    angular_momentum = angular_momentum + mass[i] * (cross(now, state.v[i]) + (dx * dx / 4) * curl);
  }
  // A body without extent in some direction keeps the rotation that it had about the others.
  rotation = polar_rotation(moved + (1e-9 * scale) * rotation);
  motion.spin = solve3(inertia(rest), angular_momentum);
}

void RigidBody::move(const RigidBodyRest& rest, double dt) {
  const Mat3d half = rotation_by((0.5 * dt) * motion.spin) * rotation;
  const Vec3d midway = solve3(times_transposed(half * rest.inertia, half), angular_momentum);
  center = center + dt * motion.velocity;
  rotation = rotation_by(dt * midway) * rotation;
  motion.spin = solve3(inertia(rest), angular_momentum);
}

}  // namespace physmas::mpm
