// Distances to some particles at rest.
#ifndef PHYSMAS_MPM_ACTION_NEAREST_H
#define PHYSMAS_MPM_ACTION_NEAREST_H

#include <memory>
#include <vector>

#include "mpm/state.h"

namespace physmas::mpm {

// Keeps references to its arguments.
class NearestAtRest {
 public:
  NearestAtRest(const Particles& rest, const std::vector<int>& particles);
  ~NearestAtRest();
  // To the nearest of `particles` [m²]; infinite when there are none.
  double squared_distance(const Vec3d& x) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace physmas::mpm

#endif
