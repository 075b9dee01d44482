// What Young's modulus and Poisson's ratio mean for an isotropic solid.
#ifndef PHYSMAS_BASE_ELASTICITY_H
#define PHYSMAS_BASE_ELASTICITY_H

#include <cmath>

namespace physmas {

// Lamé parameters [of E] (paper, Eq. "supp-lame").
struct Lame {
  double mu, lambda;
};
inline Lame lame(double E, double nu) {
  return {E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))};
}

// Speed of the fastest elastic wave [m/s] (paper, Eq. "supp-wavespeed"); E [Pa], rho [kg/m^3].
inline double wave_speed(double E, double nu, double rho) {
  const Lame l = lame(E, nu);
  return std::sqrt((l.lambda + 2 * l.mu) / rho);
}

}  // namespace physmas

#endif
