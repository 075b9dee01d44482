#include "records/material_field.h"

#include <fmt/format.h>

#include "base/error.h"
#include "records/hdf5_file.h"

namespace physmas {
namespace {

// As schemas/candidate.json has them for a row.
constexpr double kLargestModulus = 1e15, kLargestDensity = 1e9;

}  // namespace

std::string sample_fault(double E, double nu, double rho) {
  // What float32 rounds to zero is none, either.
  if (!(static_cast<float>(E) > 0 && E <= kLargestModulus)) return fmt::format("a Young's modulus of {} Pa", E);
  if (!(nu >= 0 && nu <= 0.5)) return fmt::format("a Poisson's ratio of {}", nu);
  if (!(static_cast<float>(rho) > 0 && rho <= kLargestDensity)) return fmt::format("a density of {} kg/m^3", rho);
  return "";
}

MaterialField load_material_field(const std::string& path) {
  const Hdf5Reader file(path, "material_field");
  file.allow_only({"/samples/position", "/samples/youngs_modulus", "/samples/poisson_ratio", "/samples/density"});
  MaterialField field;
  field.E = file.read_float("/samples/youngs_modulus", {UINT64_MAX}, kMaxFieldSamples);
  const uint64_t n = field.E.size();
  if (n == 0) throw file.invalid("/samples/youngs_modulus", "no samples", "at least one");
  field.nu = file.read_float("/samples/poisson_ratio", {n});
  field.rho = file.read_float("/samples/density", {n});
  const std::vector<float> position = file.read_float("/samples/position", {n, 3});
  field.position.resize(n);
  for (uint64_t i = 0; i < n; ++i) {
    field.position[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2]};
    const std::string fault = sample_fault(field.E[i], field.nu[i], field.rho[i]);
    if (!fault.empty()) throw file.invalid("/samples", fmt::format("{} in sample {}", fault, i), "that of a material");
  }
  return field;
}

void save_material_field(const std::string& path, const MaterialField& field, const Provenance& provenance) {
  Hdf5Writer file(path, "material_field", provenance);
  const uint64_t n = field.size();
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float), "positions are stored without padding");
  file.write_float("/samples/position", {n, 3}, field.position.front().data());
  file.write_float("/samples/youngs_modulus", {n}, field.E.data());
  file.write_float("/samples/poisson_ratio", {n}, field.nu.data());
  file.write_float("/samples/density", {n}, field.rho.data());
  file.commit();
}

}  // namespace physmas
