// From a record's branch to the solver's. Both follow the paper's Table "constitutive".
#ifndef PHYSMAS_BIND_BRANCH_H
#define PHYSMAS_BIND_BRANCH_H

#include <string_view>

#include "mpm/material/branch.h"
#include "records/labels.h"

namespace physmas::bind {

constexpr mpm::Branch bind_branch(Branch branch) {
  return static_cast<mpm::Branch>(static_cast<int>(branch));
}

namespace branch_detail {

constexpr bool same_branches() {
  if (kBranchCount != mpm::kBranchCount) return false;
  for (int b = 0; b < kBranchCount; ++b) {
    if (std::string_view(kBranchNames[b]) != mpm::kBranchNames[b]) return false;
  }
  return bind_branch(Branch::jelly) == mpm::Branch::jelly && bind_branch(Branch::metal) == mpm::Branch::metal &&
         bind_branch(Branch::sand) == mpm::Branch::sand && bind_branch(Branch::foam) == mpm::Branch::foam &&
         bind_branch(Branch::snow) == mpm::Branch::snow && bind_branch(Branch::plasticine) == mpm::Branch::plasticine;
}
static_assert(same_branches(), "records and solver disagree about the branches, their order or their names");

}  // namespace branch_detail

}  // namespace physmas::bind

#endif
