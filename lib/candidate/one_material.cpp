#include "candidate/one_material.h"

#include <algorithm>

namespace physmas::candidate {
namespace {

// Index of the semantic row of `object` with the largest volume, -1 without one.
int largest_row(const Inventory& inventory, const std::string& object, const std::vector<double>& volume) {
  int largest = -1;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].object != object || inventory.rows[r].residual) continue;
    if (largest < 0 || volume[r] > volume[largest]) largest = static_cast<int>(r);
  }
  return largest;
}

}  // namespace

void give_one_material(Evidence& evidence, const Inventory& inventory, const std::vector<double>& volume) {
  const std::vector<EvidenceRow> own = evidence.rows;
  for (size_t r = 0; r < evidence.rows.size(); ++r) {
    const int from = largest_row(inventory, inventory.rows[r].object, volume);
    if (from < 0) continue;
    evidence.rows[r] = own[from];
    evidence.rows[r].key = own[r].key;
    evidence.rows[r].gaussians = own[r].gaussians;
    evidence.rows[r].field.reset();
  }
}

void bound_stiffness(Configuration& configuration) {
  for (CandidateRow& row : configuration.rows) {
    if (row.E > kSupportE) row = stiff_support(row);
  }
}

bool has_one_material(const Inventory& inventory, const Configuration& configuration) {
  const std::vector<CandidateRow>& rows = configuration.rows;
  return std::all_of(rows.begin(), rows.end(), [&](const CandidateRow& a) {
    const auto first = std::find_if(rows.begin(), rows.end(), [&](const CandidateRow& b) {
      return inventory.rows[b.row].object == inventory.rows[a.row].object;
    });
    return a.branch == first->branch && a.E == first->E && a.nu == first->nu && a.rho == first->rho;
  });
}

}  // namespace physmas::candidate
