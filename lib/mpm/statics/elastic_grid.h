// Linear elasticity of particles on the solver's grid: the same nodes, weights and gradients as the substep's (moving
// least squares, reference.h), with the particles as quadrature points. What it calls the stiffness is therefore the
// derivative of the substep's own nodal forces.
#ifndef PHYSMAS_MPM_STATICS_ELASTIC_GRID_H
#define PHYSMAS_MPM_STATICS_ELASTIC_GRID_H

#include <array>
#include <cstdint>
#include <vector>

#include "base/team.h"
#include "mpm/domain.h"
#include "mpm/material/material.h"
#include "mpm/math/isotropic.h"
#include "mpm/state.h"

namespace physmas::mpm::statics {

// A vector at a node. The fourth number fills the register and stays zero.
typedef double Vec4 __attribute__((vector_size(32)));
using NodeField = std::vector<Vec4>;

// Without registers of that width GCC remarks on how such a vector is returned, which is never from another file.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
inline Vec4 to_vec4(const Vec3d& v) {
  return Vec4{v.x, v.y, v.z, 0};
}
#pragma GCC diagnostic pop
inline Vec3d to_vec3(const Vec4& v) {
  return {v[0], v[1], v[2]};
}

// 2 μ ε + λ tr ε I.
inline Symmetric<double> elastic_stress(const Symmetric<double>& strain, double mu, double lambda) {
  Symmetric<double> tau = (2 * mu) * strain;
  const double volumetric = lambda * trace(strain);
  tau.xx += volumetric, tau.yy += volumetric, tau.zz += volumetric;
  return tau;
}

// Nodes that some particle's stencil reaches are numbered by x, then y, then z. Results do not depend on the team's
// threads, byte for byte.
class ElasticGrid {
 public:
  // chosen: the particles that take part, indices into `particles`. parameters: per row.
  ElasticGrid(const Domain& domain, const Particles& particles, const std::vector<int>& chosen,
              const std::vector<MaterialParameters<double>>& parameters, Team& team);

  size_t node_count() const { return place_.size(); }
  const std::array<int, 3>& place(size_t node) const { return place_[node]; }  // node (i, j, k)
  const std::vector<double>& mass() const { return mass_; }                    // per node [kg]

  double gradient() const { return gradient_; }

  // Particles in the grid's own order, in which stresses and strains are given.
  size_t size() const { return points_.size(); }
  int particle(size_t point) const { return points_[point].particle; }
  int row(size_t point) const { return points_[point].row; }
  double volume(size_t point) const { return points_[point].volume; }  // m^3
  // How much of a node's stiffness is the particle's, but for w_aq [J].
  double stiffness_weight(size_t point) const {
    const Point& p = points_[point];
    return p.volume * (p.lambda + 2 * p.mu);
  }
  // Makes the particle yield: its moduli are these shares of the row's, of μ and of λ + 2 μ / 3.
  // Returns whether that changes one of them by more than a tenth.
  bool soften(size_t point, double shear, double bulk) {
    Point& p = points_[point];
    const double mu = p.mu, volumetric = p.lambda + 2 * mu / 3;
    p.mu = shear * p.row_mu;
    p.lambda = bulk * p.row_bulk - 2 * p.mu / 3;
    return std::fabs(p.mu - mu) > 0.1 * mu || std::fabs(bulk * p.row_bulk - volumetric) > 0.1 * volumetric;
  }
  // Of a strain, with the particle's present moduli.
  Symmetric<double> stress(size_t point, const Symmetric<double>& strain) const {
    return elastic_stress(strain, points_[point].mu, points_[point].lambda);
  }
  // function(node, w, offset in cells) for the 27 nodes of a particle.
  template <class Function>
  void for_each_node(size_t point, const Function& function) const;

  // Symmetric gradients of a displacement u [m], per particle.
  void strains(const NodeField& u, std::vector<Symmetric<double>>& strain) const;
  // Σ_q V_q τ_q ∇w_aq of Kirchhoff stresses [Pa]: what stress takes from the nodes' forces [N].
  void internal_forces(const std::vector<Symmetric<double>>& tau, NodeField& force) const;
  // The internal forces of the stress 2 μ ε + λ tr ε I of a displacement u.
  void stiffness(const NodeField& u, NodeField& force) const;
  // The 3×3 blocks on the diagonal of the stiffness [N/m].
  std::vector<Symmetric<double>> diagonal() const;
  // Σ_a w_aq value_a per particle.
  std::vector<double> gather(const std::vector<double>& value) const;
  std::vector<Vec3d> gather(const NodeField& value) const;

  // Σ_q w_aq m_q share_q per node [kg].
  std::vector<double> scatter_mass(const std::vector<double>& share) const;

  // A number per node, the same for nodes that particles connect: components, counted from 0 in the order of nodes.
  std::vector<int> components(int& count) const;
  int any_node(size_t point) const { return columns_[points_[point].cell][0]; }  // of its 27

 private:
  struct Point {
    Vec3d at;  // from the first node of its stencil, cells: 0.5 to 1.5
    double volume, mass;
    double row_mu, row_bulk, mu, lambda;  // Pa
    int particle, row, cell;
  };
  // The first of three consecutive nodes in each of the nine columns of a cell's stencil.
  using Columns = std::array<int, 9>;

  template <class Function>
  void for_each_block(const Function& function) const;
  template <class Stress>
  void gather_scatter(const NodeField* u, NodeField* force, const Stress& stress) const;

  // Quadratic B-splines of the three nodes at 0, 1 and 2 for a point at 0.5 to 1.5, and the offsets of the nodes.
  struct Weights {
    double w[3], offset[3];
    explicit Weights(double at) {
      w[0] = 0.5 * (1.5 - at) * (1.5 - at);
      w[1] = 0.75 - (at - 1) * (at - 1);
      w[2] = 0.5 * (at - 0.5) * (at - 0.5);
      for (int n = 0; n < 3; ++n) offset[n] = n - at;
    }
  };

  double gradient_;  // 4/dx: of the weights times offsets in cells [1/m]
  Team& team_;
  std::vector<Point> points_;
  std::vector<Columns> columns_;
  std::vector<int> block_begin_;           // first point of each block, and the end
  std::array<int, 9> color_begin_{};       // first block of each colour, and the end
  std::vector<std::array<int, 3>> place_;  // per node
  std::vector<double> mass_;
};

template <class Function>
void ElasticGrid::for_each_node(size_t point, const Function& function) const {
  const Point& p = points_[point];
  const Weights x(p.at.x), y(p.at.y), z(p.at.z);
  const Columns& columns = columns_[p.cell];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        function(columns[3 * i + j] + k, x.w[i] * y.w[j] * z.w[k], Vec3d{x.offset[i], y.offset[j], z.offset[k]});
}

}  // namespace physmas::mpm::statics

#endif
