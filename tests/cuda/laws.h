// Every law and decomposition of the solver on one particle, for plain numbers, SIMD lanes and a GPU alike: what these
// are compared by.
#ifndef PHYSMAS_TESTS_CUDA_LAWS_H
#define PHYSMAS_TESTS_CUDA_LAWS_H

#include "mpm/material/stiffness.h"

namespace laws {

using namespace physmas::mpm;

// What `evaluate` writes: stresses and energies in units of λ + 2 μ, the strength in units of the first one.
constexpr int kStress = 0, kDeformation = 9, kStrength = 18, kStateStress = 19, kEnergy = 28, kStiffness = 29,
              kRotation = 30, kSingular = 39, kProduct = 42, kNumbers = 51;

template <class T>
PHYSMAS_HOST_DEVICE inline void write(const Mat3<T>& a, const T& unit, T* out) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out[3 * i + j] = a[i][j] / unit;
  }
}

// One step of dt from the trial state F with the strength p.yield; the state's stress and energy, before that; its
// stiffness; its polar rotation, singular values and their product U diag(s) Vᵀ. out: [kNumbers].
template <class T>
PHYSMAS_HOST_DEVICE inline void evaluate(Branch branch, const MaterialParameters<T>& p, const T& dt,
                                         const Mat3<T>& trial, T* out) {
  const T modulus = p.lambda + p.mu + p.mu, one(1);
  Mat3<T> F = trial;
  T strength = p.yield;
  write(update_branch(branch, p, dt, F, strength), modulus, out + kStress);
  write(F, one, out + kDeformation);
  out[kStrength] = strength / p.yield;
  write(branch_stress(branch, p, trial), modulus, out + kStateStress);
  out[kEnergy] = branch_energy(branch, p, trial) / modulus;
  out[kStiffness] = stiffness_bound(branch, p, trial) / modulus;
  write(polar_rotation(trial), one, out + kRotation);
  const Svd<T> d = svd(trial);
  for (int i = 0; i < 3; ++i) out[kSingular + i] = d.s[i];
  write(d.U * (diagonal(d.s.x, d.s.y, d.s.z) * d.Vt), one, out + kProduct);
}

// How far two evaluations may differ, in units of a rounding: twenty to forty operations deep, on numbers of order one;
// the bound of stiffness has quotients of differences of stretches, and logarithms of their own accuracy.
constexpr double kRoundings = 256, kRoundingsOfStiffness = 4096;

}  // namespace laws

#endif
