// What the particles of a register add to the energy budget of a substep (energy_budget.h).
#ifndef PHYSMAS_MPM_CPU_MEASURE_ENERGY_H
#define PHYSMAS_MPM_CPU_MEASURE_ENERGY_H

#include <algorithm>

#include "mpm/energy_budget.h"
#include "mpm/material/constitutive.h"
#include "mpm/math/lanes.h"

namespace physmas::mpm {

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
  return at_most(Wide(kRootTwoThirds) * p.yield * (before - after), at_least(loss, Wide(0)));
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

// One register of particles in one substep. Lanes whose volume is zero count for nothing.
template <class V>
struct RegisterMotion {
  V mass, volume;
  Vec3<V> x;                       // after the substep, in cells from `origin`
  Mat3<V> F_before, F_trial, F;    // before the substep, before and after the return map
  Vec3<V> v_gathered, v, v_moved;  // before and after controls; what the place moved with
  Mat3<V> C_gathered, C, C_moved;  // likewise; what F advanced with
};

// Adds the register's state energy and, unless dt is 0 (a state that was just loaded), its losses and works.
// branch: [lanes]; origin: position of the cells' origin [m].
template <class V>
void measure_register(const RegisterMotion<V>& g, const MaterialParameters<V>& parameters, const Branch* branch,
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
