// Sums over grid nodes from which a rigid motion is found in the least-squares sense.
#ifndef PHYSMAS_MPM_RIGID_NODE_MOMENTS_H
#define PHYSMAS_MPM_RIGID_NODE_MOMENTS_H

#include <array>

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// The motion u(x) = velocity + spin × (x − center) of a body whose centre is known.
struct Twist {
  Vec3d velocity = {0, 0, 0};  // m/s
  Vec3d spin = {0, 0, 0};      // 1/s
  Vec3d at(const Vec3d& from_center) const { return velocity + cross(spin, from_center); }
};

// Of Σ w |u − velocity − spin × x|² / 2 over nodes of weight w [kg], velocity u [m/s], at x [m] from some origin.
struct NodeMoments {
  double w = 0;                                     // Σ w
  Vec3d wx = {0, 0, 0};                             // Σ w x
  std::array<double, 6> wxx = {};                   // Σ w x xᵀ: xx, yy, zz, xy, xz, yz
  Vec3d wu = {0, 0, 0};                             // Σ w u
  Mat3d wxu = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};  // Σ w x uᵀ

  // Adds the sums of others, whose origin lies at `d` from this one's.
  void add(const NodeMoments& other, const Vec3d& d) {
    w += other.w;
    wx = wx + other.wx + other.w * d;
    constexpr int kFirst[6] = {0, 1, 2, 0, 0, 1}, kSecond[6] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; ++k) {
      const int a = kFirst[k], b = kSecond[k];
      wxx[k] += other.wxx[k] + other.wx[a] * d[b] + d[a] * other.wx[b] + other.w * d[a] * d[b];
    }
    wu = wu + other.wu;
    for (int a = 0; a < 3; ++a) wxu[a] = wxu[a] + other.wxu[a] + d[a] * other.wu;
  }
  // Σ w x × u
  Vec3d angular() const { return {wxu[1][2] - wxu[2][1], wxu[2][0] - wxu[0][2], wxu[0][1] - wxu[1][0]}; }
};

}  // namespace physmas::mpm

#endif
