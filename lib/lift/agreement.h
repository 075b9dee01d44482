// Which views say of the same Gaussians what the others say: a detector that takes one thing for another does so in
// single views.
#ifndef PHYSMAS_LIFT_AGREEMENT_H
#define PHYSMAS_LIFT_AGREEMENT_H

#include <cstdint>
#include <utility>
#include <vector>

#include "records/masks.h"

namespace physmas::lift {

// Of two views, from this many Gaussians that both see inside a mask on, it is known whether they agree.
constexpr long kSharedLeast = 20;
// A view contradicts another where less than this share of the Gaussians lies in a mask of the same row in both; from
// the second on they agree.
constexpr double kContradiction = 0.5, kAgreement = 0.7;

struct Agreement {
  // Views that contradict every other view of which that is known, at least two, while most pairs of those agree.
  std::vector<size_t> contradicted;
  // Pairs of the other views that contradict each other all the same: nobody knows which is right.
  std::vector<std::pair<size_t, size_t>> undecided;
};

// pixels[v][i]: of Gaussian i in view v, negative where the view does not see it.
Agreement compare_views(const std::vector<ViewMasks>& views, const std::vector<std::vector<int32_t>>& pixels);

}  // namespace physmas::lift

#endif
