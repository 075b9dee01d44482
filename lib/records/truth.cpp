#include "records/truth.h"

#include <fmt/format.h>

#include "base/error.h"
#include "records/hdf5_file.h"

namespace physmas {
namespace {

constexpr const char* kDataset = "/gaussians/row";

}  // namespace

void save_truth(const std::string& path, const std::vector<int32_t>& row, const Provenance& provenance) {
  Hdf5Writer file(path, "truth", provenance);
  file.write_int(kDataset, {row.size()}, row.data());
  file.commit();
}

std::vector<int32_t> load_truth(const std::string& path, const Inventory& inventory, size_t count) {
  const Hdf5Reader file(path, "truth");
  file.allow_only({kDataset});
  const std::vector<int32_t> truth = file.read_int(kDataset, {count});
  const int rows = static_cast<int>(inventory.rows.size());
  for (const int32_t row : truth) {
    if (row < 0 || row >= rows)
      throw file.invalid(kDataset, std::to_string(row), fmt::format("rows 0..{} of the bundle's inventory", rows - 1));
  }
  return truth;
}

}  // namespace physmas
