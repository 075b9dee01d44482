// The fourteen visual labels and the six solver branches: the paper's Table "mapping", once.
#ifndef PHYSMAS_RECORDS_LABELS_H
#define PHYSMAS_RECORDS_LABELS_H

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace physmas {

// Constitutive branches (paper, Table "constitutive"), in the paper's order.
enum class Branch : int { jelly = 0, metal, sand, foam, snow, plasticine };
constexpr int kBranchCount = 6;
inline constexpr std::array<const char*, kBranchCount> kBranchNames = {"Jelly", "Metal", "Sand",
                                                                       "Foam",  "Snow",  "Plasticine"};

// One row of Table "mapping". E in Pa, rho in kg/m^3, both in solver space.
struct LabelPrior {
  const char* name;
  Branch branch;
  double E_lo, E_hi;
  double nu_lo, nu_hi;
  double rho;
  double E_default() const;  // geometric midpoint of the range
  double nu_default() const { return 0.5 * (nu_lo + nu_hi); }
  // The label's domain clamps (paper, clip^E_m and clip^nu_m).
  double clip_E(double E) const { return std::min(std::max(E, E_lo), E_hi); }
  double clip_nu(double nu) const { return std::min(std::max(nu, nu_lo), nu_hi); }
};

constexpr int kLabelCount = 14;
inline constexpr std::array<LabelPrior, kLabelCount> kLabels = {{
    {"Wood", Branch::metal, 1e8, 2e10, 0.25, 0.45, 700},
    {"Metal", Branch::metal, 1e9, 3e11, 0.20, 0.35, 7800},
    {"Plastic", Branch::metal, 1e6, 5e9, 0.30, 0.45, 1200},
    {"Glass", Branch::metal, 1e9, 1e11, 0.18, 0.30, 2500},
    {"Fabric", Branch::foam, 1e4, 1e8, 0.20, 0.45, 500},
    {"Leather", Branch::foam, 1e5, 1e9, 0.30, 0.49, 900},
    {"Ceramic", Branch::metal, 1e8, 1e11, 0.15, 0.35, 2500},
    {"Stone", Branch::metal, 1e8, 1e11, 0.10, 0.35, 2600},
    {"Rubber", Branch::jelly, 1e4, 1e8, 0.40, 0.499, 1100},
    {"Paper", Branch::foam, 1e5, 1e9, 0.20, 0.45, 800},
    {"Sand", Branch::sand, 1e3, 1e7, 0.20, 0.45, 1600},
    {"Snow", Branch::snow, 1e3, 1e7, 0.10, 0.35, 300},
    {"Plasticine", Branch::plasticine, 1e3, 1e7, 0.25, 0.49, 2000},
    {"Foam", Branch::foam, 1e3, 1e7, 0.10, 0.45, 100},
}};

// Of ordinary rows in the solver: least and most (paper, "Visual-to-Solver Mapping and Parameter Domain").
inline constexpr std::array<double, 2> kSolverNu = {0.05, 0.45};
inline constexpr std::array<double, 2> kSolverRho = {300, 3000};  // kg/m^3

// Indices into kLabels.
enum VisualLabel : int {
  kWood = 0,
  kMetal,
  kPlastic,
  kGlass,
  kFabric,
  kLeather,
  kCeramic,
  kStone,
  kRubber,
  kPaper,
  kSand,
  kSnow,
  kPlasticine,
  kFoam
};

// Wood, Metal, Glass, Ceramic and Stone: the labels that the support predicates count as rigid (not Plastic).
constexpr bool is_rigid_label(int label) {
  return label == kWood || label == kMetal || label == kGlass || label == kCeramic || label == kStone;
}

// Index into kLabels, ignoring case; empty when the name is not one of the fourteen.
std::optional<int> find_label(const std::string& name);
// As find_label, for the six branches.
std::optional<Branch> find_branch(const std::string& name);
inline const char* branch_name(Branch branch) {
  return kBranchNames[static_cast<int>(branch)];
}

}  // namespace physmas

#endif
