// The motion of bodies that are locked to the nodes of the grid: the minimum, over their twists U, of
//
//   Σ_a min over admissible u of m_a |u − u*_a|² / 2 + Σ_b κ_ab |u − U_b(x_a)|² / 2
//
// with u*_a what a node has without the lock, and κ_ab the stiffness that a body's material has there in one step. Free
// nodes are sums (NodeMoments); nodes in obstacles and nodes of several bodies are listed one by one.
#ifndef PHYSMAS_MPM_RIGID_RIGID_SOLVE_H
#define PHYSMAS_MPM_RIGID_RIGID_SOLVE_H

#include <vector>

#include "mpm/rigid/node_moments.h"
#include "mpm/rigid/node_obstacle.h"
#include "mpm/rigid/rigid_setup.h"
#include "mpm/rigid/small_solve.h"

namespace physmas::mpm {

// A body's share of a node in an obstacle. Where several bodies share a node each has its own, with its part of what
// does not belong to a body.
struct HeldNode {
  int body;
  Vec3d from_center;  // of the body [m]
  double mass;        // kg
  double lock;        // κ [kg]
  Vec3d u;            // u* [m/s]
  NodeObstacles obstacles;

  // What the node moves with when its body has velocity U there, before the obstacles.
  Vec3d free(const Vec3d& U) const { return (1 / (mass + lock)) * (mass * u + lock * U); }
  double weight() const { return mass * lock / (mass + lock); }
};

// Two bodies that share a node. While they approach, a damper of the two locks in a row is between them; when they
// part, nothing is. Momentum goes from one to the other.
struct BodyPair {
  int body[2];
  Vec3d from_center[2];  // m
  Vec3d normal;          // from the first into the second, or zero: no side to part to
  double lock;           // kg
};

// What a step needs to know. Body b is unknown unless `prescribed`.
struct RigidSystem {
  std::vector<NodeMoments> free;  // per body: weights m κ/(m + κ) and velocities u*, about the body's centre
  std::vector<HeldNode> held;
  std::vector<BodyPair> pairs;
  std::vector<char> prescribed;
};

// How hard obstacles and other bodies push in a solution.
struct RigidImpact {
  double approach = 0;  // m/s: the largest that contact takes away at a node
  // By which the impulses of the compliant contact would have to grow to stop the approach altogether; infinite where
  // there are none.
  double share = 0;
};

class RigidSolver {
 public:
  // Twists of all bodies with and without contact; start: first guess, holds the motion of prescribed bodies.
  std::vector<Twist> solve(const RigidSystem& system, const std::vector<Twist>& start, bool contact);
  // The twist that a body's nodes have by themselves.
  static Twist fit(const NodeMoments& moments);
  RigidImpact impact(const RigidSystem& system, const std::vector<Twist>& free, const std::vector<Twist>& met) const;

 private:
  void set_up(const RigidSystem& system);
  std::vector<Twist> solve_free(std::vector<Twist> at) const;
  // Gradient at `at`; returns its size, in the metric of the lock.
  double residual(const RigidSystem& system, const std::vector<Twist>& at, std::vector<double>& gradient) const;
  void assemble(const RigidSystem& system, const std::vector<Twist>& at);
  std::vector<Twist> stepped(const std::vector<Twist>& from, const std::vector<double>& step, double length) const;

  int unknowns_ = 0;
  std::vector<int> first_;  // per body: its first unknown, -1: prescribed
  // Without contact: matrix in blocks of 6 × 6 per body, right side.
  std::vector<double> base_, base_right_;
  std::vector<double> gradient_, trial_gradient_;
  DenseFactors factors_;  // of the Jacobian where it was last needed: contact changes little from step to step
};

}  // namespace physmas::mpm

#endif
