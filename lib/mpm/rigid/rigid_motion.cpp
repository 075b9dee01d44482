#include "mpm/rigid/rigid_motion.h"

#include <algorithm>
#include <cmath>

#include "mpm/rigid/small_solve.h"

namespace physmas::mpm {

namespace {

// A compliant contact that stops less than a thousandth of the approach has hardly begun. Glancing ones never stop
// much.
constexpr double kLargestShare = 1000;
// One that stops more than half of it is an impact that a rebound can be made of.
constexpr double kReboundShare = 2;

// What an enforced control leaves of a body's own motion.
Twist prescribed_twist(const Control& c, const Vec3d& center, const Twist& own) {
  const Vec3d offset = center - c.center;
  Vec3d field = c.velocity + c.gradient * offset;
  Vec3d spin = 0.5 * Vec3d{c.gradient[2][1] - c.gradient[1][2], c.gradient[0][2] - c.gradient[2][0],
                           c.gradient[1][0] - c.gradient[0][1]};
  const double speed = norm(field);
  if (speed > c.speed_limit) {
    field = (c.speed_limit / speed) * field;
    spin = (c.speed_limit / speed) * spin;
  }
  if (c.brake && dot(own.velocity, field) <= dot(field, field)) return own;
  const double along = c.blend.along == 1 ? 1 : 0, across = c.blend.across == 1 ? 1 : 0;
  Twist twist;
  twist.velocity =
      (1 - across) * own.velocity + across * field + ((along - across) * dot(c.axis, field - own.velocity)) * c.axis;
  twist.spin = across == 1 || norm(spin) > 0 ? spin : own.spin;
  return twist;
}

}  // namespace

RigidMotion::RigidMotion(const RigidSetup& setup, double dx, const Vec3d& gravity)
    : setup_(setup),
      dx_(dx),
      gravity_(gravity),
      bodies_(setup.bodies.size()),
      history_(setup.bodies.size()),
      prescribed_(setup.bodies.size()),
      near_(setup.bodies.size(), 1),
      twists_(setup.bodies.size()) {}

void RigidMotion::hold(const State& state, const std::vector<double>& mass) {
  for (int b = 0; b < count(); ++b) bodies_[b].fit(rest(b), setup_.offset, state, mass, dx_);
  held_ = true;
  alert_ = true;
}

void RigidMotion::store(State& state) const {
  for (int b = 0; b < count(); ++b) {
    const RigidBody& body = bodies_[b];
    const Mat3d spin = cross_matrix(body.motion.spin);
    for (const int i : rest(b).particles) {
      const Vec3d offset = body.rotation * setup_.offset[i];
      state.x[i] = body.center + offset;
      state.v[i] = body.motion.at(offset);
      state.C[i] = spin;
      state.F[i] = deformation(i, b);
      if (!state.total_F.empty()) state.total_F[i] = body.rotation;
    }
  }
}

double RigidMotion::speed_bound(int b) const {
  return norm(bodies_[b].motion.velocity) + norm(bodies_[b].motion.spin) * rest(b).radius;
}

double RigidMotion::kinetic() const {
  double sum = 0;
  for (int b = 0; b < count(); ++b) {
    const Twist& motion = bodies_[b].motion;
    sum += 0.5 * rest(b).mass * dot(motion.velocity, motion.velocity);
    sum += 0.5 * dot(motion.spin, bodies_[b].angular_momentum);
  }
  return sum;
}

bool RigidMotion::solve(double dt, RigidSystem& system, bool fresh) {
  std::vector<Twist> start(count());
  system.prescribed.assign(count(), 0);
  for (int b = 0; b < count(); ++b) {
    start[b] = bodies_[b].motion;
    if (!prescribed_[b].enforces()) continue;
    // Where the field leaves a direction free, the body's own motion falls on.
    Twist own = start[b];
    own.velocity = own.velocity + dt * gravity_;
    start[b] = prescribed_twist(prescribed_[b], bodies_[b].center, own);
    system.prescribed[b] = 1;
  }
  pattern_.clear();
  if (system.held.empty() && system.pairs.empty()) {
    twists_ = solver_.solve(system, start, false);
    return true;
  }
  const std::vector<Twist> met = solver_.solve(system, start, true);
  twists_ = met;
  // Most contact is rest: what the bodies bring with them tells without another solution.
  double fastest = 0;
  for (int b = 0; b < count(); ++b) {
    if (!system.prescribed[b]) fastest = std::max(fastest, speed_bound(b) + dt * norm(gravity_));
  }
  if (!(fastest > kImpactSpeed)) return true;
  const std::vector<Twist> free = solver_.solve(system, start, false);
  const RigidImpact impact = solver_.impact(system, free, met);
  if (!(impact.approach > kImpactSpeed)) return true;
  if (windows_ && fresh && impact.share <= kLargestShare) {
    double sum = 0;
    approach_ = 0;
    const auto add = [&](int body, const Vec3d& from_center, const Vec3d& impulse) {
      pattern_.push_back({body, from_center, impulse});
      approach_ += dot(impulse, free[body].at(from_center));
      sum += norm(impulse);
    };
    for (const HeldNode& node : system.held) {
      if (system.prescribed[node.body]) continue;
      const Vec3d U = met[node.body].at(node.from_center), pushed = node.free(U);
      const Vec3d taken = node.obstacles.apply(pushed) - pushed;
      if (dot(taken, taken) > 0) add(node.body, node.from_center, node.lock * (node.obstacles.apply(pushed) - U));
    }
    for (const BodyPair& pair : system.pairs) {
      const Vec3d relative = met[pair.body[1]].at(pair.from_center[1]) - met[pair.body[0]].at(pair.from_center[0]);
      const double closing = -dot(relative, pair.normal);
      if (!(closing > 0)) continue;
      add(pair.body[1], pair.from_center[1], (pair.lock * closing) * pair.normal);
      add(pair.body[0], pair.from_center[0], (-pair.lock * closing) * pair.normal);
    }
    if (sum > 0) approach_ /= sum;
    return false;
  }
  double restitution = 0;
  for (int b = 0; b < count(); ++b) restitution = std::max(restitution, history_[b].restitution);
  if (impact.share <= kReboundShare) {
    for (int b = 0; b < count(); ++b) {
      if (system.prescribed[b]) continue;
      const double share = (1 + restitution) * impact.share;
      twists_[b].velocity = free[b].velocity + share * (met[b].velocity - free[b].velocity);
      twists_[b].spin = free[b].spin + share * (met[b].spin - free[b].spin);
      if (norm(met[b].velocity - free[b].velocity) > 0.1 * impact.approach) ++history_[b].impacts;
    }
  }
  return true;
}

void RigidMotion::finish(double dt, const std::vector<NodeMoments>& moments) {
  alert_ = false;
  for (int b = 0; b < count(); ++b) {
    RigidBody& body = bodies_[b];
    const Vec3d before = body.motion.velocity;
    if (prescribed_[b].enforces()) {
      body.set_motion(rest(b), twists_[b]);
    } else {
      // The rigid motion with the momentum and the angular momentum of the body's share of the nodes.
      body.set_motion(rest(b), RigidSolver::fit(moments[b]));
      const double jump = norm(body.motion.velocity - before);
      history_[b].largest_jump = std::max(history_[b].largest_jump, jump);
      if (jump < kImpactSpeed) {
        history_[b].largest_acceleration = std::max(history_[b].largest_acceleration, jump / dt);
      }
    }
    body.move(rest(b), dt);
    alert_ = alert_ || (windows_ && near_[b] && !prescribed_[b].enforces() &&
                        speed_bound(b) + dt * norm(gravity_) > kImpactSpeed);
  }
}

void RigidMotion::measure_rebound() {
  double leaving = 0, sum = 0;
  for (const Impulse& p : pattern_) {
    leaving += dot(p.impulse, bodies_[p.body].motion.at(p.from_center));
    sum += norm(p.impulse);
  }
  if (!(sum > 0) || !(approach_ < 0)) return;
  const double restitution = std::min(1.0, std::max(0.0, leaving / (sum * -approach_)));
  for (int b = 0; b < count(); ++b) {
    const auto hit = [&](const Impulse& p) { return p.body == b; };
    if (std::none_of(pattern_.begin(), pattern_.end(), hit)) continue;
    double& known = history_[b].restitution;
    known = known < 0 ? restitution : 0.5 * (known + restitution);
  }
  pattern_.clear();
}

}  // namespace physmas::mpm
