// state.h5: Gaussian labels and initial particles, the paper's Z^0.
#ifndef PHYSMAS_RECORDS_STATE_H
#define PHYSMAS_RECORDS_STATE_H

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas {

// The isotropic map N(x) = s x + d from scene to solver space (paper, "Solver-Aware Shared-Domain Simulation").
struct SolverMap {
  double s = 1;                                 // > 0
  Eigen::Vector3d d = Eigen::Vector3d::Zero();  // solver units
  double length = 2;                            // L, edge of the solver cube
  int n = 100;                                  // cells per axis
  Eigen::Vector3d to_solver(const Eigen::Vector3d& x) const { return s * x + d; }
  Eigen::Vector3d to_scene(const Eigen::Vector3d& x) const { return (x - d) / s; }
};

// Where a scene has more Gaussians than the run simulates: some of them, the carriers, are particles, and the others
// move with those near them. Empty where all are particles.
struct Carriers {
  static constexpr int kPerGaussian = 4;
  std::vector<int32_t> gaussian;      // [N_C] the Gaussians that are particles, ascending
  std::vector<Eigen::Vector3f> rest;  // [N_G] rest means of all, solver space
  // [N_G, kPerGaussian] what each follows: particles below N_C of the same row, and weights that sum to 1. A carrier
  // follows itself.
  std::vector<int32_t> particle;
  std::vector<float> weight;
  bool empty() const { return gaussian.empty(); }
};

// What a material field says of the particles (records/material_field.h), as its file has it. Empty where the scene has
// none.
struct ParticleField {
  std::vector<float> E, nu, rho;  // [N_Q] Pa, Poisson's ratio, kg/m^3; E = 0: no sample is near enough
  double reach = 0;               // how near that is, solver units
  bool empty() const { return E.empty(); }
  bool has_sample(size_t q) const { return E[q] > 0; }
};

struct State {
  // Gaussians, file order, [N_G].
  std::vector<int32_t> gaussian_object;    // index into inventory.objects
  std::vector<int32_t> gaussian_row;       // index into inventory.rows; never -1
  std::vector<float> gaussian_confidence;  // 0..1
  Carriers carriers;
  // Particles, [N_Q]; the first carrier_count() are Gaussians.
  std::vector<Eigen::Vector3f> position;  // solver space
  std::vector<float> volume;              // rest volume V_q^0, solver units cubed
  std::vector<int32_t> row;
  std::vector<int32_t> object;
  std::vector<int32_t> source;  // source Gaussian iota(q), paper Eq. (particlesource)
  ParticleField field;
  SolverMap map;
  std::vector<std::string> row_keys;  // inventory.rows when the state was made
  std::vector<Omission> omitted;

  size_t gaussian_count() const { return gaussian_row.size(); }
  // The Gaussians that are particles: N_G, or N_C where there are carriers.
  size_t carrier_count() const { return carriers.empty() ? gaussian_count() : carriers.gaussian.size(); }
  size_t particle_count() const { return row.size(); }
  // Gaussians with each row, [inventory.rows].
  std::vector<long> gaussians_per_row() const;
  // Rest volume of each row's particles, [inventory.rows], solver units cubed.
  std::vector<double> volume_per_row() const;
};

// Checks sizes, index ranges, finite positions inside [0, L]^3, volumes > 0, and that the first particles are the
// Gaussians, or the carriers. `inventory`, when given, must have the rows that the state was made with.
State load_state(const std::string& path, const Inventory* inventory = nullptr);
// The rows of Gaussians and particles, the volumes and the field alone, as stages need them that ask for sums by row;
// the rest of the state is empty and was not read. Checked as far.
State load_state_rows(const std::string& path, const Inventory& inventory);
void save_state(const std::string& path, const State& state, const Provenance& provenance);

}  // namespace physmas

#endif
