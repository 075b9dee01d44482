#include "mpm/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <thread>

#include "base/clock.h"
#include "mpm/material/carry.h"
#include "mpm/math/svd.h"
#include "mpm/statics/conjugate_gradients.h"
#include "mpm/statics/supports.h"

namespace physmas::mpm {

namespace {

using statics::ConjugateGradients;
using statics::ElasticGrid;
using statics::NodeField;
using statics::Supports;
using statics::to_vec3;
using statics::to_vec4;
using statics::Vec4;
using Stress = std::vector<Symmetric<double>>;

// Of the force that is left against gravity, in ConjugateGradients::size: of a balance that is final, and of one after
// which another follows, because contacts would have to pull or rows do not bear it.
constexpr double kTolerance = 5e-3, kRoughTolerance = 0.05;
constexpr int kMostIterations = 2000, kMostRoughIterations = 120;  // per balance
constexpr int kMostCorrections = 16, kMostYields = 6;
constexpr double kSoftest = 1e-4;  // share of a modulus that is left to what yields
// A particle touches a support when so much of its weight lies on nodes that the support holds: one that is 1.3 cells
// above the nodes of a floor does not.
constexpr double kTouch = 0.02;
// A part is held up when its supports balance its weight up to this share.
constexpr double kUnbalanced = 0.3;
// And when its particles feel less than this share of gravity: with F = I it is all of it.
constexpr double kUseless = 0.7;

double size_of_deviator(const Symmetric<double>& a) {
  const double mean = trace(a) / 3;
  return std::sqrt(squared_norm(Symmetric<double>{a.xx - mean, a.yy - mean, a.zz - mean, a.xy, a.xz, a.yz}));
}

struct Elasticity {
  std::vector<MaterialParameters<double>> parameters;  // per row
  std::vector<Branch> branches;
  const Particles* particles = nullptr;
  MaterialParameters<double> of(int particle) const {
    const MaterialParameters<double>& row = parameters[particles->row[particle]];
    return particles->material.empty() ? row : with_elasticity(row, elasticity_of(particles->material[particle]));
  }
};

// Particles that an action holds at the start.
std::vector<char> held_particles(const Problem& problem) {
  std::vector<char> held(problem.particles.size(), 0);
  const ActionPlan actions(problem.schedule.actions, problem.particles);
  std::vector<Control> controls;
  if (!actions.controls(0, 1e-9, controls)) return held;
  const std::vector<std::uint16_t>& group = actions.group_of();
  for (size_t q = 0; q < held.size(); ++q) {
    const Control& c = controls[group[q]];
    held[q] = c.blend.along == 1 && c.blend.across == 1 && c.top_speed() == 0;
  }
  return held;
}

// Σ w m per node, of the particles that are held.
std::vector<double> held_mass(const ElasticGrid& grid, const std::vector<char>& held) {
  std::vector<double> share(grid.size());
  for (size_t p = 0; p < grid.size(); ++p) share[p] = held[grid.particle(p)];
  return grid.scatter_mass(share);
}

// The indices of those of `particles` that are in parts with a particle that touches a support; the numbers of parts.
std::vector<int> supported_particles(const ElasticGrid& grid, const Supports& supports, int& supported, int& free) {
  int count = 0;
  const std::vector<int> component = grid.components(count);
  std::vector<double> touched(grid.node_count());
  for (size_t a = 0; a < touched.size(); ++a) touched[a] = supports.touches(a);
  const std::vector<double> share = grid.gather(touched);
  std::vector<char> holds(count, 0);
  for (size_t p = 0; p < grid.size(); ++p) {
    if (share[p] >= kTouch) holds[component[grid.any_node(p)]] = 1;
  }
  supported = static_cast<int>(std::count(holds.begin(), holds.end(), 1));
  free = count - supported;
  std::vector<int> chosen;
  for (size_t p = 0; p < grid.size(); ++p) {
    if (holds[component[grid.any_node(p)]]) chosen.push_back(grid.particle(p));
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// Stress and deformation per point of the grid.
struct Carrying {
  Stress tau;
  std::vector<Mat3d> F;
  std::vector<char> limited;
};

// The balance of the parts that may be supported.
class Balancing {
 public:
  Balancing(const Problem& problem, const Elasticity& rows, ElasticGrid& grid, Supports supports, Team& team);
  void solve(Equilibrium& result);
  // F: per particle of the problem.
  void report(std::vector<Mat3d>& F, Equilibrium& result) const;

 private:
  struct Part {
    // What its particles feel over their weight, Σ m a² over Σ m g², and with min(a², g²): a few light ones that
    // nothing can hold must not hide that the rest is in balance.
    double felt = 0, felt_bounded = 0;
    double net = 0;  // all forces together over the weight
    double mass = 0;
    bool left = false;  // to itself: it is not in balance
  };
  NodeField force(const Stress& tau) const;  // gravity less stress
  void balance(double tolerance, int most, Equilibrium& result);
  bool carry(Carrying& now);
  std::vector<Part> judge(const Carrying& now) const;

  const Problem& problem_;
  const Elasticity& rows_;
  ElasticGrid& grid_;
  Supports supports_, best_supports_;
  Team& team_;
  std::unique_ptr<ConjugateGradients> solver_;
  int part_count_ = 0;
  std::vector<int> part_of_;  // per node
  NodeField displacement_, weight_;
  std::vector<double> weight_size_;
  Carrying best_;
};

Balancing::Balancing(const Problem& problem, const Elasticity& rows, ElasticGrid& grid, Supports supports, Team& team)
    : problem_(problem),
      rows_(rows),
      grid_(grid),
      supports_(std::move(supports)),
      best_supports_(supports_),
      team_(team),
      part_of_(grid.components(part_count_)),
      displacement_(grid.node_count(), Vec4{0, 0, 0, 0}) {
  for (size_t a = 0; a < grid.node_count(); ++a) {
    const Vec3d w = grid.mass()[a] * problem.domain.gravity;
    weight_.push_back(to_vec4(w));
    weight_size_.push_back(norm(w));
  }
}

NodeField Balancing::force(const Stress& tau) const {
  NodeField f;
  grid_.internal_forces(tau, f);
  for (size_t a = 0; a < f.size(); ++a) f[a] = weight_[a] - f[a];
  return f;
}

// Brings the displacement to the balance of the present moduli and supports.
void Balancing::balance(double tolerance, int most, Equilibrium& result) {
  NodeField missing = weight_;
  supports_.project(missing);
  const double asked = solver_->size(supports_, missing);
  grid_.stiffness(displacement_, missing);
  solver_->add_springs(displacement_, missing);
  for (size_t a = 0; a < missing.size(); ++a) missing[a] = weight_[a] - missing[a];
  supports_.add_friction(missing);
  result.iterations += solver_->solve(supports_, missing, tolerance * asked, most, displacement_);
}

// The stress that rows bear at the present displacement. Where they yield, their moduli become those of a line from
// zero to what they bear, so that the next balance asks others. Returns whether moduli changed.
bool Balancing::carry(Carrying& now) {
  Stress strain;
  grid_.strains(displacement_, strain);
  now = {Stress(grid_.size()), std::vector<Mat3d>(grid_.size()), std::vector<char>(grid_.size())};
  std::vector<char> changed(grid_.size(), 0);
  constexpr int kRange = 256;
  const int size = static_cast<int>(grid_.size());
  team_.for_each((size + kRange - 1) / kRange, [&](int range) {
    for (int p = range * kRange; p < std::min(size, (range + 1) * kRange); ++p) {
      const int row = grid_.row(p);
      const MaterialParameters<double> m = rows_.of(grid_.particle(p));
      const Symmetric<double> wanted = statics::elastic_stress(strain[p], m.mu, m.lambda);
      const Carried carried = carry_stress(rows_.branches[row], m, wanted);
      now.tau[p] = carried.tau;
      now.F[p] = carried.F;
      now.limited[p] = carried.limited;
      const auto share = [](double borne, double asked) {
        return asked > 0 ? std::min(1.0, std::max(kSoftest, borne / asked)) : 1.0;
      };
      const double shear = share(size_of_deviator(carried.tau), size_of_deviator(wanted));
      const double bulk = share(trace(carried.tau) * (trace(wanted) > 0 ? 1 : -1), std::fabs(trace(wanted)));
      changed[p] = grid_.soften(p, shear, bulk);
    }
  });
  return std::any_of(changed.begin(), changed.end(), [](char c) { return c != 0; });
}

std::vector<Balancing::Part> Balancing::judge(const Carrying& now) const {
  NodeField acceleration = force(now.tau);
  std::vector<Vec3d> net(part_count_, Vec3d{0, 0, 0});
  for (size_t a = 0; a < acceleration.size(); ++a) {
    const Vec3d f = to_vec3(acceleration[a]), left = f + supports_.reaction(a, f);
    net[part_of_[a]] = net[part_of_[a]] + left;
    const double mass = grid_.mass()[a];
    acceleration[a] = to_vec4((mass > 0 ? 1 / mass : 0) * left);
  }
  const std::vector<Vec3d> felt = grid_.gather(acceleration);
  const double gravity = norm(problem_.domain.gravity);
  std::vector<Part> parts(part_count_);
  for (size_t p = 0; p < grid_.size(); ++p) {
    Part& part = parts[part_of_[grid_.any_node(p)]];
    const double m = rows_.of(grid_.particle(p)).density * grid_.volume(p);
    const double squared = dot(felt[p], felt[p]) / (gravity * gravity);
    part.felt += m * squared;
    part.felt_bounded += m * std::min(1.0, squared);
    part.mass += m;
  }
  for (int c = 0; c < part_count_; ++c) {
    parts[c].felt /= parts[c].mass;
    parts[c].felt_bounded /= parts[c].mass;
    parts[c].net = norm(net[c]) / (parts[c].mass * gravity);
    parts[c].left = parts[c].net > kUnbalanced || std::sqrt(parts[c].felt_bounded) > kUseless;
  }
  return parts;
}

void Balancing::solve(Equilibrium& result) {
  double best = std::numeric_limits<double>::infinity();
  int yields = 0;  // balances that asked more than rows bear
  int stale = 0;   // of them, the last ones in a row that helped little
  for (int correction = 0; correction <= kMostCorrections && yields <= kMostYields; ++correction) {
    // A preconditioner for moduli that are somewhat larger does nearly as well as a new one.
    if (correction == 0 || yields == 1 || yields == 3)
      solver_ = std::make_unique<ConjugateGradients>(grid_, supports_, team_);
    balance(kRoughTolerance, yields > 0 ? kMostRoughIterations : kMostIterations, result);
    Carrying now;
    bool softened = carry(now);
    int moved = supports_.update(force(now.tau), displacement_, weight_size_);
    if (moved == 0 && !softened && yields == 0) {
      balance(kTolerance, kMostIterations, result);
      softened = carry(now);
      moved = supports_.update(force(now.tau), displacement_, weight_size_);
    }
    yields += softened;
    result.corrections = correction;
    double felt = 0, mass = 0;
    for (const Part& part : judge(now)) felt += part.mass * part.felt, mass += part.mass;
    felt = std::sqrt(felt / mass);
    if (!std::isfinite(felt)) break;
    stale = felt < 0.95 * best ? 0 : stale + 1;
    if (felt < best) {
      // What was better on supports that would have had to pull does not count.
      best = moved > 0 ? std::numeric_limits<double>::infinity() : felt;
      best_ = std::move(now);
      best_supports_ = supports_;
    }
    if (moved == 0 && (!softened || stale > 1)) break;
  }
  supports_ = best_supports_;
}

void Balancing::report(std::vector<Mat3d>& F, Equilibrium& result) const {
  if (best_.F.empty()) {  // numbers that overflow
    result.free_parts += result.supported_parts;
    result.supported_parts = 0;
    return;
  }
  const std::vector<Part> parts = judge(best_);
  const int left = static_cast<int>(std::count_if(parts.begin(), parts.end(), [](const Part& p) { return p.left; }));
  result.supported_parts -= left;
  result.free_parts += left;
  double felt = 0, mass = 0;
  for (const Part& part : parts) {
    if (!part.left) felt += part.mass * part.felt_bounded, mass += part.mass;
  }
  if (mass > 0) result.residual = std::sqrt(felt / mass);
  for (size_t p = 0; p < grid_.size(); ++p) {
    if (parts[part_of_[grid_.any_node(p)]].left) continue;
    F[grid_.particle(p)] = best_.F[p];
    ++result.supported_particles;
    result.limited[grid_.row(p)] += best_.limited[p];
    const Vec3d s = svd(best_.F[p]).s;
    result.largest_strain = std::max({result.largest_strain, std::fabs(std::log(s.x)), std::fabs(std::log(s.z))});
  }
}

int team_size(const Device& device, size_t particles) {
  constexpr int kParticlesPerThread = 2000;  // with fewer, threads wait for one another for longer than they save
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int most = static_cast<int>(particles) / kParticlesPerThread;
  return std::max(1, std::min(device.threads > 0 ? device.threads : cores, most));
}

}  // namespace

Equilibrium find_equilibrium(const Problem& problem, const Device& device) {
  check_problem(problem, {});
  const Stopwatch watch;
  Equilibrium result;
  result.limited.assign(problem.materials.size(), 0);
  if (problem.particles.size() == 0 || !(norm(problem.domain.gravity) > 0)) return result;
  Elasticity rows;
  rows.particles = &problem.particles;
  for (const Material& m : problem.materials) {
    rows.branches.push_back(m.branch);
    rows.parameters.push_back(derive_parameters(m, problem.constants));
  }
  Team team(team_size(device, problem.particles.size()));
  const std::vector<char> held = held_particles(problem);
  std::vector<int> chosen(problem.particles.size());
  std::iota(chosen.begin(), chosen.end(), 0);
  {
    const ElasticGrid all(problem.domain, problem.particles, chosen, rows.parameters, team);
    const Supports supports(problem.domain, all, held_mass(all, held));
    chosen = supported_particles(all, supports, result.supported_parts, result.free_parts);
  }
  if (!chosen.empty()) {
    ElasticGrid grid(problem.domain, problem.particles, chosen, rows.parameters, team);
    Balancing balancing(problem, rows, grid, Supports(problem.domain, grid, held_mass(grid, held)), team);
    balancing.solve(result);
    std::vector<Mat3d> F(problem.particles.size(), identity<double>());
    balancing.report(F, result);
    if (result.supported_particles > 0) result.deformation_gradient = std::move(F);
  }
  result.seconds = watch.seconds();
  return result;
}

}  // namespace physmas::mpm
