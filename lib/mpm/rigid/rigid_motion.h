// All rigid bodies of a run: where they are, how a substep moves them, and what they have run into.
#ifndef PHYSMAS_MPM_RIGID_RIGID_MOTION_H
#define PHYSMAS_MPM_RIGID_RIGID_MOTION_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/rigid/rigid_body.h"
#include "mpm/rigid/rigid_solve.h"

namespace physmas::mpm {

// Approaches below this are rest, not impact [m/s]: a rebound would be about a tenth of a cell.
constexpr double kImpactSpeed = 0.2;

// What a body has been through.
struct RigidHistory {
  double largest_acceleration = 0;  // m/s^2: while rigid
  double largest_jump = 0;          // m/s: of its velocity in one substep, impacts without a window included
  long long impacts = 0;            // approaches above kImpactSpeed that the rigid motion met itself
  double restitution = -1;          // measured in its impact windows; -1: none yet
};

class RigidMotion {
 public:
  RigidMotion(const RigidSetup& setup, double dx, const Vec3d& gravity);

  bool empty() const { return setup_.empty(); }
  int count() const { return static_cast<int>(setup_.bodies.size()); }
  const Vec3d& gravity() const { return gravity_; }
  const RigidBodyRest& rest(int body) const { return setup_.bodies[body]; }
  const RigidBody& body(int body) const { return bodies_[body]; }
  const RigidHistory& history(int body) const { return history_[body]; }

  // Whether bodies are rigid now; else they deform, as they do in an impact.
  bool held() const { return held_; }
  // Takes over the state's particles. mass: per particle [kg].
  void hold(const State& state, const std::vector<double>& mass);
  void let_go() { held_ = false; }
  // Particles of bodies as their motion has them: x, v, C, F.
  void store(State& state) const;
  // F of a particle of a body.
  Mat3d deformation(int particle, int body) const {
    return setup_.F.empty() ? bodies_[body].rotation : bodies_[body].rotation * setup_.F[particle];
  }

  // Motion that an action enforces on a body in the coming substep, of nullptr: none.
  void prescribe(int body, const Control* control) { prescribed_[body] = control ? *control : Control(); }

  bool prescribes() const {
    for (const Control& c : prescribed_)
      if (c.enforces()) return true;
    return false;
  }

  // One substep. The stiffness of a body's mass m at a node is m × lock_share(body, dt).
  double lock_share(int body, double dt) const { return setup_.bodies[body].lock * dt * dt; }
  // From the nodes to the bodies' twists, with which nodes and then `finish` go on. fresh: the state before this
  // substep can still be had, so that an impact may be met as material. False: it should be, and nothing has moved.
  bool solve(double dt, RigidSystem& system, bool fresh);
  const std::vector<Twist>& twists() const { return twists_; }
  // moments: per body its own mass and velocity at nodes, about its centre.
  void finish(double dt, const std::vector<NodeMoments>& moments);

  // Impacts are asked to be met as material while a window is allowed.
  void allow_windows(bool allow) { windows_ = allow; }
  // Whether the next substep may meet an impact: some body is fast, and `near` something. Then the state before it is
  // worth keeping.
  bool alert() const { return alert_; }
  void set_near(const std::vector<char>& near) { near_ = near; }

  // What the last impact that `solve` stopped at looked like, and how the bodies left it: their restitution.
  void measure_rebound();
  double approach() const { return -approach_; }  // m/s
  // Of the bodies [J]: kinetic, of their rigid motion.
  double kinetic() const;
  double speed_bound(int body) const;

 private:
  const RigidSetup& setup_;
  double dx_;
  Vec3d gravity_;
  std::vector<RigidBody> bodies_;
  std::vector<RigidHistory> history_;
  std::vector<Control> prescribed_;
  std::vector<char> near_;
  std::vector<Twist> twists_;
  RigidSolver solver_;
  bool held_ = false, windows_ = false, alert_ = false;
  // The impulses of the impact that is being met as material: where on which body, along what [kg m/s].
  struct Impulse {
    int body;
    Vec3d from_center, impulse;
  };
  std::vector<Impulse> pattern_;
  double approach_ = 0;  // m/s along the pattern
};

}  // namespace physmas::mpm

#endif
