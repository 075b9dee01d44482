// The linear system of a static balance.
#ifndef PHYSMAS_MPM_STATICS_CONJUGATE_GRADIENTS_H
#define PHYSMAS_MPM_STATICS_CONJUGATE_GRADIENTS_H

#include <vector>

#include "mpm/statics/coarse_space.h"
#include "mpm/statics/elastic_grid.h"
#include "mpm/statics/supports.h"

namespace physmas::mpm::statics {

// Some motions strain no particle: a sheet of one layer that bends, nodes that few particles see. Nothing balances
// gravity there. Springs of mass / kPatience² hold the nodes [s]: what would take longer than that to swing is left to
// the simulation, and what is faster feels next to nothing of them.
constexpr double kPatience = 1;

// (K + springs) u = force in the space that supports leave free, by conjugate gradients, with the inverse of the 3×3
// blocks on the diagonal and the coarse space as preconditioner. In double precision, sums in one order.
class ConjugateGradients {
 public:
  ConjugateGradients(const ElasticGrid& grid, const Supports& supports, Team& team);

  // Adds the solution of `force` [N] to u [m], until the residual is `tolerance` in size() or after `most`
  // iterations. Returns their number.
  int solve(const Supports& supports, const NodeField& force, double tolerance, int most, NodeField& u) const;
  // √(fᵀ P⁻¹ f) with the preconditioner P of a force [N] of which supports hold nothing.
  double size(const Supports& supports, const NodeField& force) const;
  // The forces of the springs [N], to be added to the internal ones.
  void add_springs(const NodeField& u, NodeField& force) const;

 private:
  void precondition(const Supports& supports, const NodeField& r, NodeField& z) const;
  double dot(const NodeField& a, const NodeField& b) const;
  template <class Work>
  void for_each_range(const Work& work) const;

  const ElasticGrid& grid_;
  Team& team_;
  std::vector<double> spring_;                    // [N/m]
  std::vector<Symmetric<double>> inverse_block_;  // of the diagonal [m/N]
  const CoarseSpace coarse_;
};

}  // namespace physmas::mpm::statics

#endif
