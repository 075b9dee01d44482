// What a row is made of, and the constants of the six solver profiles.
#ifndef PHYSMAS_MPM_MATERIAL_MATERIAL_H
#define PHYSMAS_MPM_MATERIAL_MATERIAL_H

#include <cmath>

#include "base/constants.h"
#include "base/elasticity.h"
#include "mpm/material/branch.h"
#include "mpm/math/real.h"

namespace physmas::mpm {

// One row's material (paper, Tables "mapping" and "constitutive").
struct Material {
  Branch branch = Branch::jelly;
  double E = 1e5;     // Young's modulus [Pa], > 0
  double nu = 0.3;    // Poisson ratio, -1 < nu < 0.5
  double rho = 1000;  // density at rest [kg/m^3], > 0
};

// Constants that the profiles share between rows, in solver-space units. Part of the run specification.
struct ProfileConstants {
  double foam_yield = 2e3;             // [Pa] von Mises strength: |dev tau| <= sqrt(2/3) yield at rest
  double foam_viscosity = 10;          // [Pa s] flow resistance beyond the yield strength
  double plasticine_yield = 2e3;       // [Pa]
  double plasticine_softening = 200;   // [Pa per unit plastic strain] strength lost to damage
  double plasticine_residual = 0.1;    // strength left after full damage, as a fraction of plasticine_yield
  double sand_friction_angle = 30;     // [degrees]
  double drucker_prager_alpha = 0.16;  // slope of the stress cone of Sand, Snow and Plasticine
  double sand_cohesion = 0;            // k of the stress cone [Pa]
  double snow_cohesion = 1000;         // [Pa]
  double plasticine_cohesion = 5000;   // [Pa]
};

// The numbers that the constitutive functions read, derived from a Material and the profile constants.
template <class T>
struct MaterialParameters {
  T mu, lambda;       // Lamé parameters [Pa] (paper, Eq. "supp-lame")
  T bulk;             // lambda + 2 mu / 3 [Pa]
  T density;          // [kg/m^3]
  T inverse_mu;       // 1 / (2 mu) [1/Pa]
  T friction;         // sand: the cone |dev tau| <= -friction tr tau of the return map (Klar et al. 2016)
  T strain_friction;  // the same cone of strains: |dev eps| <= -strain_friction tr eps
  T alpha, cohesion;  // stress cone |dev tau| <= max(0, cohesion - alpha tr tau)
  T apex;             // tr tau / 3 at its tip [Pa]
  T yield;            // foam and plasticine: initial von Mises strength [Pa]
  T viscosity;        // foam [Pa s]
  T softening;        // plasticine [Pa]
  T residual_yield;   // plasticine: strength never falls below this [Pa]
};

// What of a material may differ from particle to particle of a row; the branch and the constants of its profile may
// not.
template <class T>
struct ParticleElasticity {
  T mu, lambda;  // Lamé parameters [Pa]
  T density;     // [kg/m^3]
};

inline ParticleElasticity<double> elasticity_of(const Material& m) {
  const Lame elastic = lame(m.E, m.nu);
  return {elastic.mu, elastic.lambda, m.rho};
}

// The parameters of a row with what a particle of it has of its own.
template <class T>
PHYSMAS_HOST_DEVICE PHYSMAS_INLINE MaterialParameters<T> with_elasticity(MaterialParameters<T> p,
                                                                         const ParticleElasticity<T>& own) {
  p.mu = own.mu;
  p.lambda = own.lambda;
  p.bulk = own.lambda + Scalar<T>(2) * own.mu / T(Scalar<T>(3));
  p.density = own.density;
  p.inverse_mu = T(Scalar<T>(0.5)) / own.mu;
  p.strain_friction = p.friction * (Scalar<T>(3) * own.lambda + Scalar<T>(2) * own.mu) * p.inverse_mu;
  return p;
}

inline MaterialParameters<double> derive_parameters(const Material& m, const ProfileConstants& c) {
  MaterialParameters<double> p{};
  const double sine = std::sin(c.sand_friction_angle * kPi / 180);
  p.friction = kRootTwoThirds * 2 * sine / (3 - sine);
  p.alpha = c.drucker_prager_alpha;
  p.cohesion = m.branch == Branch::sand   ? c.sand_cohesion
               : m.branch == Branch::snow ? c.snow_cohesion
                                          : c.plasticine_cohesion;
  constexpr double kNoTip = 1e30;  // where the cone is a cylinder; fits every type
  p.apex = p.cohesion < 3 * p.alpha * kNoTip ? p.cohesion / (3 * p.alpha) : p.cohesion > 0 ? kNoTip : 0;
  p.yield = m.branch == Branch::foam ? c.foam_yield : c.plasticine_yield;
  p.viscosity = c.foam_viscosity;
  p.softening = c.plasticine_softening;
  p.residual_yield = c.plasticine_residual * c.plasticine_yield;
  return with_elasticity(p, elasticity_of(m));
}

// Each number from the same number of the given parameters.
template <class T, class Function, class... From>
PHYSMAS_INLINE MaterialParameters<T> map_parameters(const Function& to, const MaterialParameters<From>&... p) {
  return {to(p.mu...),       to(p.lambda...),          to(p.bulk...),      to(p.density...),       to(p.inverse_mu...),
          to(p.friction...), to(p.strain_friction...), to(p.alpha...),     to(p.cohesion...),      to(p.apex...),
          to(p.yield...),    to(p.viscosity...),       to(p.softening...), to(p.residual_yield...)};
}
// In another type: the solver's precision, or the same in every SIMD lane.
template <class T, class From>
PHYSMAS_HOST_DEVICE inline MaterialParameters<T> convert_parameters(const MaterialParameters<From>& p) {
  return map_parameters<T>([](From number) { return T(static_cast<Scalar<T>>(number)); }, p);
}
template <class Condition, class T>
PHYSMAS_INLINE MaterialParameters<T> select(const Condition& c, const MaterialParameters<T>& a,
                                            const MaterialParameters<T>& b) {
  return map_parameters<T>([&](const T& yes, const T& no) PHYSMAS_LAMBDA_INLINE { return select(c, yes, no); }, a, b);
}

// Speed of the fastest elastic wave at rest [m/s].
inline double wave_speed(const Material& m) {
  return physmas::wave_speed(m.E, m.nu, m.rho);
}

}  // namespace physmas::mpm

#endif
