// truth.h5: the true row of every Gaussian of a synthesised bundle.
#ifndef PHYSMAS_RECORDS_TRUTH_H
#define PHYSMAS_RECORDS_TRUTH_H

#include <cstdint>
#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/provenance.h"

namespace physmas {

// row: [N] index into the rows of the bundle's inventory. Atomic.
void save_truth(const std::string& path, const std::vector<int32_t>& row, const Provenance& provenance);

// [N] as saved. Errors (exit code 3): no such file, or
// not `count` rows of `inventory`.
std::vector<int32_t> load_truth(const std::string& path, const Inventory& inventory, size_t count);

}  // namespace physmas

#endif
