// Where the energy of a substep goes, term by term. Measured only when asked for; internal to the solver.
//
// The energy of a state is kinetic (with the affine part of APIC) + elastic + gravity. In one substep
//   change = control + projection + contact − transfer − plastic − viscous + residual.
// Transfer losses are never negative: P2G is an average of the particles' affine fields at a node (Jensen), G2P an
// orthogonal projection of node velocities onto one affine field (Jiang et al. 2015). What is left over is the error of
// the time integration, of second order in dt for one step and of first order for a given time.
#ifndef PHYSMAS_MPM_ENERGY_BUDGET_H
#define PHYSMAS_MPM_ENERGY_BUDGET_H

#include <algorithm>

#include "mpm/material/constitutive.h"

namespace physmas::mpm {

// Sums over substeps [J].
struct EnergyBudget {
  double change = 0;      // of kinetic + elastic + gravity
  double transfer = 0;    // lost between particles and grid
  double contact = 0;     // put in by walls and colliders: negative, friction and inelastic impact
  double plastic = 0;     // lost in return maps
  double viscous = 0;     // lost to Foam's flow resistance beyond its yield strength
  double projection = 0;  // put in by the stress cone of Sand, Snow and Plasticine, which has no potential
  double control = 0;     // put in by actions
  double structure = 0;   // put in by structure projection and interface retention at output frames
  double largest_step_residual = 0;

  double residual() const {
    return change - (control + structure + projection + contact - transfer - plastic - viscous);
  }
  void add(const EnergyBudget& b) {
    change += b.change, transfer += b.transfer, contact += b.contact, plastic += b.plastic, viscous += b.viscous;
    projection += b.projection, control += b.control, structure += b.structure;
    largest_step_residual = std::max(largest_step_residual, b.largest_step_residual);
  }
};

// What particles report from one pass [J].
struct ParticleEnergy {
  double gathered = 0;        // kinetic, as it comes from the grid
  double state = 0;           // kinetic + elastic + gravity after controls
  double scattered = 0;       // kinetic, as it goes to the grid
  double plastic = 0;         // lost
  double viscous = 0;         // lost
  double projection = 0;      // put in
  double control_after = 0;   // put in by enforced velocities after G2P
  double control_before = 0;  // put in by controls before the next P2G

  void add(const ParticleEnergy& e) {
    gathered += e.gathered, state += e.state, scattered += e.scattered, plastic += e.plastic, viscous += e.viscous;
    projection += e.projection, control_after += e.control_after, control_before += e.control_before;
  }
};

// What nodes report [J].
struct GridEnergy {
  double arrived = 0;  // kinetic, as particles brought it
  double left = 0;     // kinetic, after forces, gravity and contact
  double contact = 0;  // put in by walls and colliders

  void add(const GridEnergy& e) { arrived += e.arrived, left += e.left, contact += e.contact; }
};

// Adds one node. Each of its numbers is a vector {·, x, y, z}; arrived: {mass, momentum without forces}; free, left:
// velocity before and after contact. Contact works along the mean of the first and the last velocity, so that a node
// which rests on a floor costs nothing.
template <class T>
void measure_node(const T* arrived, const T* free, const T* left, GridEnergy& out) {
  const double mass = arrived[0];
  if (!(mass > 0)) return;
  for (int a = 1; a <= 3; ++a) {
    const double u0 = arrived[a] / mass, u3 = left[a];
    out.arrived += 0.5 * mass * u0 * u0;
    out.left += 0.5 * mass * u3 * u3;
    out.contact += 0.5 * mass * (u3 - free[a]) * (u0 + u3);
  }
}

// Adds up substeps: `begin` with the first pass of an interval, then `grid` and `finish` for every substep.
class EnergyLedger {
 public:
  void begin(const ParticleEnergy& e) { before_ = e, total_ = {}; }
  void grid(const GridEnergy& e) { grid_ = e; }
  void finish(const ParticleEnergy& e) {
    EnergyBudget step;
    step.change = e.state - before_.state;
    step.transfer = (before_.scattered - grid_.arrived) + (grid_.left - e.gathered);
    step.contact = grid_.contact;
    step.plastic = e.plastic, step.viscous = e.viscous, step.projection = e.projection;
    step.control = before_.control_before + e.control_after;
    step.largest_step_residual = std::fabs(step.residual());
    total_.add(step);
    before_ = e;
  }
  const EnergyBudget& total() const { return total_; }

 private:
  ParticleEnergy before_;
  GridEnergy grid_;
  EnergyBudget total_;
};

namespace budget_detail {

using Wide = Lanes<double>;

// One register of doubles out of the lanes of x.
template <class V>
Wide widen(const V& x, int part) {
  alignas(64) typename V::value_type raw[V::size()];
  x.copy_to(raw, stdx::vector_aligned);
  return Wide(raw + part * Wide::size(), stdx::element_aligned);
}
template <class V>
Vec3<Wide> widen(const Vec3<V>& a, int part) {
  return {widen(a.x, part), widen(a.y, part), widen(a.z, part)};
}
template <class V>
Mat3<Wide> widen(const Mat3<V>& a, int part) {
  return {{widen(a[0], part), widen(a[1], part), widen(a[2], part)}};
}
template <class V>
MaterialParameters<Wide> widen(const MaterialParameters<V>& p, int part) {
  return map_parameters<Wide>([part](const V& x) { return widen(x, part); }, p);
}

// a : b
inline Wide contract(const Mat3<Wide>& a, const Mat3<Wide>& b) {
  return dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]);
}

inline bool has_return_map(Branch b) {
  return b == Branch::sand || b == Branch::foam || b == Branch::plasticine;
}

// Gradient of the energy of an F that has been through the return map, as a Kirchhoff stress; and the stress that acts.
inline void stresses(Branch branch, const MaterialParameters<Wide>& p, const Mat3<Wide>& F, Mat3<Wide>& potential,
                     Mat3<Wide>& acting) {
  if (branch == Branch::jelly || branch == Branch::metal) {
    potential = acting = branch == Branch::jelly ? jelly_stress(F, p.mu, p.bulk) : metal_stress(F, p.mu, p.lambda);
    return;
  }
  const Stretches<Wide> q = stretches(F);
  Vec3<Wide> tau = hencky_principal(q.strain, p.mu, p.lambda);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] * q.inside[i];
  potential = acting = from_principal(q.svd.U, tau);
  if (has_stress_cone(branch)) acting = from_principal(q.svd.U, project_to_cone(tau, p));
}

// Foam's loss at the yield strength; the rest of the loss is viscous. Only the deviator ε' of the strain flows, so the
// loss is μ (|ε'|² before − after), and the plastic strain the difference of the norms.
inline Wide foam_yield_loss(const MaterialParameters<Wide>& p, const Mat3<Wide>& F, const Wide& loss) {
  const Vec3<Wide> e = deviator(stretches(F).strain);
  const Wide after = norm(e), before = square_root(after * after + at_least(loss, Wide(0)) / p.mu);
  return at_most(Wide(0.81649658092772603) * p.yield * (before - after), at_least(loss, Wide(0)));
}

}  // namespace budget_detail

// Kinetic energy [J] of particles with an affine velocity field: m/2 (|v|² + dx²/4 |C|²).
template <class V>
double affine_kinetic(const V& mass, const Vec3<V>& v, const Mat3<V>& C, double dx) {
  double sum = 0;
  for (size_t part = 0; part < V::size() / budget_detail::Wide::size(); ++part) {
    const auto u = budget_detail::widen(v, part);
    const auto c = budget_detail::widen(C, part);
    sum += 0.5 * double(stdx::reduce(budget_detail::widen(mass, part) * (dot(u, u) + (dx * dx / 4) * squared_norm(c))));
  }
  return sum;
}

// One group of particles in one substep. Lanes whose volume is zero count for nothing.
template <class V>
struct GroupMotion {
  V mass, volume;
  Vec3<V> x;                       // after the substep, in cells from `origin`
  Mat3<V> F_before, F_trial, F;    // before the substep, before and after the return map
  Vec3<V> v_gathered, v, v_moved;  // before and after controls; what the place moved with
  Mat3<V> C_gathered, C, C_moved;  // likewise; what F advanced with
};

// Adds the group's state energy and, unless dt is 0 (a state that was just loaded), its losses and works.
// branch: [lanes]; origin: position of the cells' origin [m].
template <class V>
void measure_group(const GroupMotion<V>& g, const MaterialParameters<V>& parameters, const Branch* branch,
                   const Vec3d& origin, const Vec3d& gravity, double dx, double dt, ParticleEnergy& out) {
  using namespace budget_detail;
  out.state += affine_kinetic(g.mass, g.v, g.C, dx);
  if (dt > 0) {
    const double before = affine_kinetic(g.mass, g.v_gathered, g.C_gathered, dx);
    out.gathered += before;
    out.control_after += affine_kinetic(g.mass, g.v, g.C, dx) - before;
  }
  constexpr int kWide = static_cast<int>(Wide::size());
  for (int part = 0; part < static_cast<int>(V::size()) / kWide; ++part) {
    const Wide mass = widen(g.mass, part), volume = widen(g.volume, part);
    const Vec3<Wide> x = widen(g.x, part), jump = widen(g.v_moved, part) - widen(g.v_gathered, part);
    const Mat3<Wide> F = widen(g.F, part), C = widen(g.C_moved, part);
    for (int a = 0; a < 3; ++a) {
      out.state -= gravity[a] * double(stdx::reduce(mass * (origin[a] + dx * x[a])));
      // Where a control moves a particle otherwise than the grid would have, it also lifts it.
      out.control_after -= dt * gravity[a] * double(stdx::reduce(mass * jump[a]));
    }
    const MaterialParameters<Wide> p = widen(parameters, part);
    for (int b = 0; b < kBranchCount; ++b) {
      const Branch now = static_cast<Branch>(b);
      const Branch* lanes = branch + part * kWide;
      if (std::find(lanes, lanes + kWide, now) == lanes + kWide) continue;
      const Wide mine([&](auto l) { return lanes[l] == now ? 1.0 : 0.0; });
      const Wide own = volume * mine;
      const Wide energy = branch_energy(now, p, F);
      out.state += double(stdx::reduce(own * energy));
      if (!(dt > 0)) continue;
      Mat3<Wide> potential, acting;
      stresses(now, p, widen(g.F_before, part), potential, acting);
      // An enforced particle does not deform with the grid: the action does the work that strain would have taken.
      out.control_after += dt * double(stdx::reduce(own * contract(acting, C - widen(g.C_gathered, part))));
      if (has_stress_cone(now)) out.projection += dt * double(stdx::reduce(own * contract(potential - acting, C)));
      if (!has_return_map(now)) continue;
      const Wide loss = branch_energy(now, p, widen(g.F_trial, part)) - energy;
      const Wide yielding = now == Branch::foam ? foam_yield_loss(p, F, loss) : loss;
      out.plastic += double(stdx::reduce(own * yielding));
      out.viscous += double(stdx::reduce(own * (loss - yielding)));
    }
  }
}

}  // namespace physmas::mpm

#endif
