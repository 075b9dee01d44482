// The slow motions of a body for conjugate gradients: what bends a long stem takes as many iterations as there are
// nodes along it, unless such motions are solved for directly.
#ifndef PHYSMAS_MPM_STATICS_COARSE_SPACE_H
#define PHYSMAS_MPM_STATICS_COARSE_SPACE_H

#include <Eigen/SparseCholesky>
#include <vector>

#include "mpm/statics/elastic_grid.h"
#include "mpm/statics/supports.h"

namespace physmas::mpm::statics {

// Particles of one row in a block of cells move as a rigid body; a node moves with the mean of the bodies at its
// particles, weighted by their stiffness. Nodes that supports touch stay where they are.
class CoarseSpace {
 public:
  // spring [N/m]: per node, added to the stiffness.
  CoarseSpace(const ElasticGrid& grid, const Supports& supports, const std::vector<double>& spring);

  // Adds to z [m] the motion in this space that balances the part of r [N] that is seen in it.
  void add_solution(const NodeField& r, NodeField& z) const;

 private:
  static constexpr int kModes = 6;  // of a rigid body
  struct Share {
    int body;
    double weight;  // of the body at a node; those of a node add up to 1
  };
  void find_bodies(const ElasticGrid& grid, const Supports& supports);
  void factorise(const ElasticGrid& grid, const std::vector<double>& spring);
  Vec3d arm(int body, size_t node) const { return (1.0 / size_) * (node_place_[node] - center_[body]); }

  int size_ = 4;                   // of a block, cells
  std::vector<Vec3d> node_place_;  // cells
  std::vector<Vec3d> center_;      // per body, cells
  std::vector<int> share_begin_;   // per node, and the end
  std::vector<Share> shares_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace physmas::mpm::statics

#endif
