#include "mpm/rigid/rigid_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm/rigid/small_solve.h"

namespace physmas::mpm {

namespace {

constexpr int kMostIterations = 30;
constexpr int kMostHalvings = 6;
// Where a whole step comes to other contacts the residual may grow before it falls; so many may do that.
constexpr int kFreeIterations = 10;
constexpr double kRest = 1e-24;     // squared, of the residual over the motion
constexpr double kGoodStep = 1e-2;  // by which old factors have to shrink the squared residual

// Adds Jᵀ f to the gradient, J = [1, −[r]×].
void add_force(double* gradient, const Vec3d& r, const Vec3d& f) {
  const Vec3d torque = cross(r, f);
  for (int a = 0; a < 3; ++a) {
    gradient[a] += f[a];
    gradient[3 + a] += torque[a];
  }
}

// Adds J₁ᵀ D J₂ to the block of a matrix with `n` columns.
void add_block(double* block, int n, const Vec3d& r1, const Mat3d& D, const Vec3d& r2) {
  const Mat3d first = cross_matrix(r1), second = cross_matrix(r2);
  const Mat3d right = D * second;
  const Mat3d corner = first * right, lower = first * D;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      block[i * n + j] += D[i][j];
      block[i * n + 3 + j] -= right[i][j];
      block[(3 + i) * n + j] += lower[i][j];
      block[(3 + i) * n + 3 + j] -= corner[i][j];
    }
  }
}

// What a pair does at a relative velocity of the second against the first: force on the second and its slope.
Vec3d pair_force(const BodyPair& pair, const Vec3d& relative, Mat3d& slope) {
  slope = diagonal(0.0, 0.0, 0.0);
  // Bodies that lie in each other have no side to part to: they hold each other.
  const bool apart = dot(pair.normal, pair.normal) > 0 && dot(relative, pair.normal) >= 0;
  if (apart) return {0, 0, 0};
  slope = pair.lock * identity<double>();
  return pair.lock * relative;
}

}  // namespace

namespace {

// Matrix [6 × 6, rows `step` apart] and right side of a body's own nodes.
void write_normal_equations(const NodeMoments& m, double* at, int step, double* right) {
  const Mat3d first = cross_matrix(m.wx);
  const double trace = m.wxx[0] + m.wxx[1] + m.wxx[2];
  const Mat3d second = {{{trace - m.wxx[0], -m.wxx[3], -m.wxx[4]},
                         {-m.wxx[3], trace - m.wxx[1], -m.wxx[5]},
                         {-m.wxx[4], -m.wxx[5], trace - m.wxx[2]}}};
  const Vec3d angular = m.angular();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      at[i * step + j] = i == j ? m.w : 0;
      at[i * step + 3 + j] = -first[i][j];
      at[(3 + i) * step + j] = first[i][j];
      at[(3 + i) * step + 3 + j] = second[i][j];
    }
    right[i] = m.wu[i];
    right[3 + i] = angular[i];
  }
}

}  // namespace

Twist RigidSolver::fit(const NodeMoments& moments) {
  double matrix[36], x[6];
  write_normal_equations(moments, matrix, 6, x);
  DenseFactors factors;
  factors.factor(6, matrix);
  factors.solve(x);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}

void RigidSolver::set_up(const RigidSystem& system) {
  const size_t bodies = system.free.size();
  first_.assign(bodies, -1);
  unknowns_ = 0;
  for (size_t b = 0; b < bodies; ++b) {
    if (system.prescribed[b]) continue;
    first_[b] = unknowns_;
    unknowns_ += 6;
  }
  base_.resize(static_cast<size_t>(unknowns_) * 6);
  base_right_.resize(unknowns_);
  std::vector<NodeMoments> all = system.free;
  for (const HeldNode& node : system.held) {
    if (first_[node.body] < 0) continue;
    NodeMoments& m = all[node.body];
    const double w = node.weight();
    const Vec3d &x = node.from_center, &u = node.u;
    m.w += w;
    m.wx = m.wx + w * x;
    m.wu = m.wu + w * u;
    for (int a = 0; a < 3; ++a) m.wxu[a] = m.wxu[a] + (w * x[a]) * u;
    m.wxx[0] += w * x.x * x.x, m.wxx[1] += w * x.y * x.y, m.wxx[2] += w * x.z * x.z;
    m.wxx[3] += w * x.x * x.y, m.wxx[4] += w * x.x * x.z, m.wxx[5] += w * x.y * x.z;
  }
  for (size_t b = 0; b < bodies; ++b) {
    if (first_[b] >= 0) write_normal_equations(all[b], &base_[first_[b] * 6], 6, &base_right_[first_[b]]);
  }
}

double RigidSolver::residual(const RigidSystem& system, const std::vector<Twist>& at,
                             std::vector<double>& gradient) const {
  gradient.resize(unknowns_);
  for (size_t b = 0; b < at.size(); ++b) {
    if (first_[b] < 0) continue;
    const double x[6] = {at[b].velocity.x, at[b].velocity.y, at[b].velocity.z,
                         at[b].spin.x,     at[b].spin.y,     at[b].spin.z};
    for (int i = first_[b]; i < first_[b] + 6; ++i) {
      double sum = -base_right_[i];
      for (int j = 0; j < 6; ++j) sum += base_[i * 6 + j] * x[j];
      gradient[i] = sum;
    }
  }
  for (const HeldNode& node : system.held) {
    if (first_[node.body] < 0 || node.obstacles.count == 0) continue;
    const Vec3d free = node.free(at[node.body].at(node.from_center));
    const Vec3d taken = node.obstacles.apply(free) - free;
    if (taken.x == 0 && taken.y == 0 && taken.z == 0) continue;
    add_force(gradient.data() + first_[node.body], node.from_center, (-node.lock) * taken);
  }
  for (const BodyPair& pair : system.pairs) {
    const Vec3d relative = at[pair.body[1]].at(pair.from_center[1]) - at[pair.body[0]].at(pair.from_center[0]);
    Mat3d slope;
    const Vec3d force = pair_force(pair, relative, slope);
    for (int s = 0; s < 2; ++s) {
      if (first_[pair.body[s]] < 0) continue;
      add_force(gradient.data() + first_[pair.body[s]], pair.from_center[s], (s == 1 ? 1.0 : -1.0) * force);
    }
  }
  // In kg m²/s²: forces and torques by the diagonal of the lock.
  double size = 0;
  for (int i = 0; i < unknowns_; ++i) {
    const double diagonal = base_[i * 6 + i % 6];
    if (diagonal > 0) size += gradient[i] * gradient[i] / diagonal;
  }
  return size;
}

void RigidSolver::assemble(const RigidSystem& system, const std::vector<Twist>& at) {
  const int n = unknowns_;
  std::vector<double> matrix(static_cast<size_t>(n) * n, 0);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < 6; ++j) matrix[i * n + i / 6 * 6 + j] = base_[i * 6 + j];
  }
  for (const HeldNode& node : system.held) {
    const int first = first_[node.body];
    if (first < 0 || node.obstacles.count == 0) continue;
    const Vec3d free = node.free(at[node.body].at(node.from_center));
    Mat3d slope;
    const Vec3d taken = node.obstacles.apply(free, slope) - free;
    if (taken.x == 0 && taken.y == 0 && taken.z == 0) continue;
    const Mat3d D = (node.lock * node.lock / (node.mass + node.lock)) * (identity<double>() - slope);
    add_block(matrix.data() + static_cast<size_t>(first) * n + first, n, node.from_center, D, node.from_center);
  }
  for (const BodyPair& pair : system.pairs) {
    const Vec3d relative = at[pair.body[1]].at(pair.from_center[1]) - at[pair.body[0]].at(pair.from_center[0]);
    Mat3d slope;
    pair_force(pair, relative, slope);
    for (int s = 0; s < 2; ++s) {
      for (int t = 0; t < 2; ++t) {
        const int row = first_[pair.body[s]], column = first_[pair.body[t]];
        if (row < 0 || column < 0) continue;
        add_block(matrix.data() + static_cast<size_t>(row) * n + column, n, pair.from_center[s],
                  (s == t ? 1.0 : -1.0) * slope, pair.from_center[t]);
      }
    }
  }
  factors_.factor(n, matrix.data());
}

std::vector<Twist> RigidSolver::stepped(const std::vector<Twist>& from, const std::vector<double>& step,
                                        double length) const {
  std::vector<Twist> to = from;
  for (size_t b = 0; b < from.size(); ++b) {
    for (int a = 0; first_[b] >= 0 && a < 3; ++a) {
      to[b].velocity[a] -= length * step[first_[b] + a];
      to[b].spin[a] -= length * step[first_[b] + 3 + a];
    }
  }
  return to;
}

std::vector<Twist> RigidSolver::solve_free(std::vector<Twist> at) const {
  for (size_t b = 0; b < at.size(); ++b) {
    if (first_[b] < 0) continue;
    DenseFactors factors;
    factors.factor(6, &base_[first_[b] * 6]);
    double x[6];
    std::copy_n(&base_right_[first_[b]], 6, x);
    factors.solve(x);
    at[b] = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  }
  return at;
}

std::vector<Twist> RigidSolver::solve(const RigidSystem& system, const std::vector<Twist>& start, bool contact) {
  set_up(system);
  if (unknowns_ == 0) return start;
  if (!contact) return solve_free(start);
  std::vector<Twist> at = start;
  double size = residual(system, at, gradient_);
  bool fresh = false;
  if (factors_.size() != unknowns_) {
    assemble(system, at);
    fresh = true;
  }
  for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
    // What remains is rounding, by the kinetic energy of the motion in the same metric.
    double scale = 1e-12;
    for (size_t b = 0; b < at.size(); ++b) {
      for (int a = 0; first_[b] >= 0 && a < 3; ++a) {
        const int i = first_[b] + a;
        scale += base_[i * 6 + a] * at[b].velocity[a] * at[b].velocity[a];
        scale += base_[(i + 3) * 6 + 3 + a] * at[b].spin[a] * at[b].spin[a];
      }
    }
    if (size <= kRest * scale) break;
    std::vector<double> step = gradient_;
    factors_.solve(step.data());
    double length = 1, next_size = 0;
    std::vector<Twist> next;
    for (int halving = 0;; ++halving, length /= 2) {
      next = stepped(at, step, length);
      next_size = residual(system, next, trial_gradient_);
      if (next_size <= size || halving == kMostHalvings || !fresh || iteration <= kFreeIterations) break;
    }
    if (!fresh && !(next_size < kGoodStep * size)) {
      // The contacts are not those that the factors were made for.
      assemble(system, at);
      fresh = true;
      continue;
    }
    const bool slow = !(next_size < kGoodStep * size);
    const bool stuck = !(next_size < size) && iteration > kFreeIterations;
    at = next;
    size = next_size;
    std::swap(gradient_, trial_gradient_);
    if (stuck) break;
    if (slow) assemble(system, at);
  }
  return at;
}

RigidImpact RigidSolver::impact(const RigidSystem& system, const std::vector<Twist>& free,
                                const std::vector<Twist>& met) const {
  RigidImpact impact;
  double missing = 0, gained = 0;
  for (const HeldNode& node : system.held) {
    if (system.prescribed[node.body]) continue;
    const Vec3d at_met = met[node.body].at(node.from_center), at_free = free[node.body].at(node.from_center);
    const Vec3d pushed = node.free(at_met), taken = node.obstacles.apply(pushed) - pushed;
    if (!(dot(taken, taken) > 0)) continue;
    const Vec3d coming = node.free(at_free);
    impact.approach = std::max(impact.approach, norm(node.obstacles.apply(coming) - coming));
    // The impulse on the body, along what the obstacle takes.
    const double size = norm(taken);
    const Vec3d along = (1 / size) * taken;
    const double impulse = node.lock * dot(node.obstacles.apply(pushed) - at_met, along);
    missing -= impulse * dot(at_free, along);
    gained += impulse * dot(at_met - at_free, along);
  }
  for (const BodyPair& pair : system.pairs) {
    const auto relative = [&](const std::vector<Twist>& twist) {
      return twist[pair.body[1]].at(pair.from_center[1]) - twist[pair.body[0]].at(pair.from_center[0]);
    };
    Mat3d slope;
    const Vec3d force = pair_force(pair, relative(met), slope);
    if (!(dot(force, force) > 0) || !(dot(pair.normal, pair.normal) > 0)) continue;
    impact.approach = std::max(impact.approach, -dot(relative(free), pair.normal));
    const double impulse = -dot(force, pair.normal);
    missing -= impulse * dot(relative(free), pair.normal);
    gained += impulse * dot(relative(met) - relative(free), pair.normal);
  }
  impact.share = gained > 0 ? missing / gained : std::numeric_limits<double>::infinity();
  return impact;
}

}  // namespace physmas::mpm
