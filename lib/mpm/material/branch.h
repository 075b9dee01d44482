// The six constitutive branches (paper, Table "constitutive"), in the paper's order.
#ifndef PHYSMAS_MPM_MATERIAL_BRANCH_H
#define PHYSMAS_MPM_MATERIAL_BRANCH_H

namespace physmas::mpm {

enum class Branch : int { jelly = 0, metal, sand, foam, snow, plasticine };
constexpr int kBranchCount = 6;
constexpr const char* kBranchNames[kBranchCount] = {"Jelly", "Metal", "Sand", "Foam", "Snow", "Plasticine"};

constexpr const char* branch_name(Branch branch) {
  return kBranchNames[static_cast<int>(branch)];
}

}  // namespace physmas::mpm

#endif
