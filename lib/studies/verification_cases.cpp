#include "studies/verification_cases.h"

#include <algorithm>

#include "base/constants.h"
#include "base/error.h"

namespace physmas::studies {
namespace {

using mpm::Collider;
using mpm::Problem;
using mpm::State;
using mpm::Vec3d;

constexpr double kGravity = 9.8;

Problem empty_scene(const mpm::Material& material, int n, const Vec3d& gravity) {
  Problem p;
  p.domain.n = n;
  p.domain.gravity = gravity;
  p.materials = {material};
  return p;
}

Collider floor_plane(double height, Collider::Mode mode, double friction) {
  Collider c;
  c.type = Collider::Type::plane;
  c.mode = mode;
  c.friction = friction;
  c.center = {0, 0, height};
  c.normal = {0, 0, 1};
  return c;
}

// Runs `frames` intervals of frame_dt with substeps of about dt.
mpm::Result simulate(const Problem& p, const Device& device, int frames, double frame_dt, double dt,
                     const mpm::FrameCallback& look, bool measure_steps = false) {
  mpm::Timing timing;
  timing.frames = frames + 1;
  timing.frame_dt = frame_dt;
  timing.substeps = std::max(1, static_cast<int>(std::lround(frame_dt / dt)));
  mpm::Options options;
  options.precision = mpm::Precision::full;
  options.device = device;
  options.measure_energy = false;
  options.measure_steps = measure_steps;
  mpm::Result result = mpm::run(p, timing, options, look);
  if (result.status != mpm::Status::stable) {
    throw internal_error("a verification case diverged in substep " + std::to_string(result.first_bad_step));
  }
  return result;
}

Vec3d mean(const std::vector<Vec3d>& values, size_t begin, size_t end) {
  Vec3d sum{0, 0, 0};
  for (size_t i = begin; i < end; ++i) sum = sum + values[i];
  return (1.0 / static_cast<double>(end - begin)) * sum;
}

}  // namespace

void seed(Problem& p, const Vec3d& low, const Vec3d& high, double h, int row,
          const std::function<bool(const Vec3d&)>& inside) {
  int count[3];
  Vec3d first{};
  for (int a = 0; a < 3; ++a) {
    count[a] = static_cast<int>(std::floor((high[a] - low[a]) / h + 0.5));
    first[a] = 0.5 * (low[a] + high[a]) - 0.5 * h * (count[a] - 1);
  }
  for (int i = 0; i < count[0]; ++i) {
    for (int j = 0; j < count[1]; ++j) {
      for (int k = 0; k < count[2]; ++k) {
        const Vec3d x = {first.x + h * i, first.y + h * j, first.z + h * k};
        if (inside && !inside(x)) continue;
        p.particles.position.push_back(x);
        p.particles.volume.push_back(h * h * h);
        p.particles.row.push_back(row);
        p.particles.velocity.push_back({0, 0, 0});
      }
    }
  }
}

double free_fall_error(double dt, const Device& device) {
  Problem p = empty_scene({mpm::Branch::jelly, 1e4, 0.3, 1000}, 32, {0, 0, -kGravity});
  seed(p, {0.9, 0.9, 1.2}, {1.1, 1.1, 1.4}, p.domain.dx() / 2, 0);
  double error = 0;
  simulate(p, device, 1, 0.2, dt, [&](const mpm::Frame& f) {
    for (size_t i = 0; i < f.state.size(); ++i) {
      const Vec3d& start = p.particles.position[i];
      const Vec3d expected = {start.x, start.y, start.z - 0.5 * kGravity * f.time * f.time};
      error = std::max(error, norm(f.state.x[i] - expected));
    }
  });
  return error;
}

Rotation rigid_rotation(int n, double dt, const Device& device) {
  Problem p = empty_scene({mpm::Branch::jelly, 1e7, 0.3, 1000}, n, {0, 0, 0});
  seed(p, {0.8, 0.8, 0.8}, {1.2, 1.2, 1.2}, p.domain.dx() / 2, 0);
  const size_t count = p.particles.size();
  const Vec3d center = mean(p.particles.position, 0, count);
  const Vec3d axis = {2.0 / 3, 1.0 / 3, 2.0 / 3};
  for (size_t i = 0; i < count; ++i) {
    p.particles.velocity[i] = 2 * kPi * cross(axis, p.particles.position[i] - center);
  }
  State last;
  const mpm::Result result = simulate(p, device, 1, 1.0, dt, [&](const mpm::Frame& f) { last = f.state; });
  const auto& balances = result.balances;
  Rotation r;
  const Vec3d start = balances.front().angular_momentum;
  r.momentum_drift = norm(balances.back().angular_momentum - start) / norm(start);
  const Vec3d moved = mean(last.x, 0, count);
  double sine = 0, cosine = 0;
  for (size_t i = 0; i < count; ++i) {
    const Vec3d q = p.particles.position[i] - center, x = last.x[i] - moved;
    const Vec3d flat = q - dot(q, axis) * axis;
    sine += dot(axis, cross(flat, x));
    cosine += dot(flat, x);
  }
  // Particles start without affine velocity, which takes its share m dx²/2 of the moment of inertia in the first
  // substep.
  double inertia = 0;
  for (const Vec3d& x : p.particles.position) {
    const Vec3d arm = cross(axis, x - center);
    inertia += dot(arm, arm) / static_cast<double>(count);
  }
  const double spread = 0.5 * p.domain.dx() * p.domain.dx();
  const double expected = 2 * kPi * inertia / (inertia + spread);
  r.angle_error = std::fabs(std::remainder(std::atan2(sine, cosine) - expected, 2 * kPi));
  return r;
}

double bar_frequency(int n, double dt, const Device& device) {
  const double E = 1e5, rho = 1000, length = 1, c = std::sqrt(E / rho), period = 2 * length / c;
  Problem p = empty_scene({mpm::Branch::metal, E, 0, rho}, n, {0, 0, 0});
  const double dx = p.domain.dx();
  seed(p, {0.5, 1, 1}, {1.5, 1 + 2 * dx, 1 + 2 * dx}, dx / 2, 0);
  std::vector<double> shape;
  for (size_t i = 0; i < p.particles.size(); ++i) {
    shape.push_back(std::cos(kPi * (p.particles.position[i].x - 0.5) / length));
    p.particles.velocity[i].x = 1e-4 * c * shape[i];  // strains of 1e-4: linear
  }
  constexpr int kFramesPerPeriod = 100;
  std::vector<double> crossings;
  double before = 0;
  simulate(p, device, kFramesPerPeriod, period / kFramesPerPeriod, dt, [&](const mpm::Frame& f) {
    double modal = 0;
    for (size_t i = 0; i < shape.size(); ++i) modal += shape[i] * f.state.v[i].x;
    if (f.index > 0 && (modal < 0) != (before < 0)) {
      crossings.push_back(f.time - period / kFramesPerPeriod * modal / (modal - before));
    }
    before = modal;
  });
  if (crossings.size() < 2) return 0;
  const double half_periods = static_cast<double>(crossings.size() - 1);
  return 0.5 * half_periods / (crossings.back() - crossings.front()) * period;
}

double column_error(int n, double dt, const Device& device) {
  const double E = 1e7, rho = 1000, height = 0.8, c = std::sqrt(E / rho), period = 4 * height / c;
  Problem p = empty_scene({mpm::Branch::metal, E, 0, rho}, n, {0, 0, -kGravity});
  const double dx = p.domain.dx(), ground = 0.5;
  seed(p, {1, 1, ground}, {1 + 2 * dx, 1 + 2 * dx, ground + height}, dx / 2, 0);
  p.domain.colliders.push_back(floor_plane(ground, Collider::Mode::slip, 0));
  constexpr int kFrames = 80;
  std::vector<double> displacement(p.particles.size(), 0);
  simulate(p, device, kFrames, period / kFrames, dt, [&](const mpm::Frame& f) {
    const double weight = (f.index == 0 || f.index == kFrames ? 0.5 : 1.0) / kFrames;
    for (size_t i = 0; i < displacement.size(); ++i) {
      displacement[i] += weight * (f.state.x[i].z - p.particles.position[i].z);
    }
  });
  double error = 0;
  for (size_t i = 0; i < displacement.size(); ++i) {
    const double z = p.particles.position[i].z - ground;
    error = std::max(error, std::fabs(displacement[i] + rho * kGravity / E * (height * z - 0.5 * z * z)));
  }
  return error / (rho * kGravity / E * 0.5 * height * height);
}

Collision ball_collision(int n, double dt, const Device& device) {
  Problem p = empty_scene({mpm::Branch::jelly, 1e5, 0.3, 1000}, n, {0, 0, 0});
  const double radius = 0.2, gap = 0.3, speed = 0.5;
  size_t first = 0;
  for (const double side : {-1.0, 1.0}) {
    const Vec3d center = {1 + side * (radius + gap / 2), 1, 1};
    const Vec3d corner = {radius, radius, radius};
    seed(p, center - corner, center + corner, p.domain.dx() / 2, 0,
         [&](const Vec3d& x) { return norm(x - center) < radius; });
    if (side < 0) first = p.particles.size();
  }
  const size_t count = p.particles.size();
  for (size_t i = 0; i < count; ++i) p.particles.velocity[i].x = i < first ? speed : -speed;
  Vec3d left{}, right{};
  const mpm::Result result = simulate(p, device, 4, 0.2, dt, [&](const mpm::Frame& f) {
    left = mean(f.state.v, 0, first);
    right = mean(f.state.v, first, count);
  });
  Collision c;
  c.momentum_error = norm(result.balances.back().momentum - result.balances.front().momentum) /
                     (0.5 * result.balances.front().mass * speed);
  c.restitution = (right.x - left.x) / (2 * speed);
  return c;
}

double incline_acceleration(int n, double dt, double friction, double angle, const Device& device) {
  const double a = angle * kPi / 180;
  Problem p =
      empty_scene({mpm::Branch::jelly, 2e5, 0.3, 1000}, n, {kGravity * std::sin(a), 0, -kGravity * std::cos(a)});
  seed(p, {0.5, 0.8, 0.4}, {0.9, 1.2, 0.5}, p.domain.dx() / 2, 0);
  p.domain.colliders.push_back(floor_plane(0.4, Collider::Mode::separate, friction));
  const mpm::Result r = simulate(p, device, 7, 0.04, dt, [](const mpm::Frame&) {});
  const double gain = r.balances[7].momentum.x - r.balances[3].momentum.x;
  return gain / (r.balances[0].mass * 0.16 * kGravity);
}

double sand_run_out(int n, double dt, double aspect, double alpha, const Device& device) {
  Problem p = empty_scene({mpm::Branch::sand, 1e6, 0.3, 1600}, n, {0, 0, -kGravity});
  p.constants.drucker_prager_alpha = alpha;
  const double radius = 0.4, ground = 0.25;
  const auto reach_of = [&](const Vec3d& x) { return std::hypot(x.x - ground, x.y - ground); };
  seed(p, {ground, ground, ground}, {ground + radius, ground + radius, ground + aspect * radius}, p.domain.dx() / 2, 0,
       [&](const Vec3d& x) { return reach_of(x) < radius; });
  for (const Vec3d& normal : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}}) {
    Collider mirror = floor_plane(ground, Collider::Mode::slip, 0);
    mirror.center = {ground, ground, ground};
    mirror.normal = normal;
    p.domain.colliders.push_back(mirror);
  }
  p.domain.colliders.push_back(floor_plane(ground, Collider::Mode::separate, 0.6));
  std::vector<double> reach;
  simulate(p, device, 1, 1.2, dt, [&](const mpm::Frame& f) {
    reach.clear();
    for (const Vec3d& x : f.state.x) reach.push_back(reach_of(x));
  });
  std::sort(reach.begin(), reach.end());
  return reach[static_cast<size_t>(0.99 * static_cast<double>(reach.size() - 1))] / radius - 1;
}

double lube_run_out(double aspect) {
  return aspect < 1.7 ? 1.24 * aspect : 1.6 * std::sqrt(aspect);
}

double energy_residual_of_throw(mpm::Branch branch, double dt, const Device& device) {
  Problem p = empty_scene({branch, branch == mpm::Branch::metal ? 2e5 : 5e4, 0.3, 1000}, 32, {0, 0, -kGravity});
  seed(p, {0.8, 0.8, 0.32}, {1.1, 1.1, 0.62}, p.domain.dx() / 2, 0);
  for (size_t i = 0; i < p.particles.size(); ++i) {
    const Vec3d q = p.particles.position[i] - Vec3d{0.95, 0.95, 0.47};
    p.particles.velocity[i] = {1 + 2 * q.x, -q.y, -1 - 2 * q.z};
  }
  p.domain.colliders.push_back(floor_plane(0.25, Collider::Mode::separate, 0.4));
  const mpm::Result r = simulate(
      p, device, 3, 0.04, dt, [](const mpm::Frame&) {}, true);
  return std::fabs(r.balances.back().budget.residual()) / r.balances.front().kinetic;
}

}  // namespace physmas::studies
