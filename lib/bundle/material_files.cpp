#include "bundle/material_files.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "base/error.h"
#include "base/file.h"
#include "base/zip_archive.h"
#include "bundle/usda_points.h"
#include "records/array_file.h"

namespace physmas::bundle {
namespace {

constexpr size_t kMaxMaterialFile = size_t{1} << 29;
// Positions beyond this are no coordinates of anything, and float32 of what is left after an offset must hold them.
constexpr double kFarthest = 1e12;

const char* const kNumberNames[] = {"youngs_modulus", "poisson_ratio", "density"};

MaterialSamples samples_of_arrays(std::map<std::string, Array> arrays, const std::string& file) {
  MaterialSamples samples;
  const Array& positions = arrays.at("positions");
  if (positions.shape.size() != 2 || positions.shape[1] != 3)
    throw invalid_input({file, "positions", "shape " + shape_text(positions.shape), "shape [n, 3]"});
  const size_t n = positions.shape[0];
  if (n > kMaxFieldSamples)
    throw invalid_input({file, "positions", fmt::format("{} samples", n), fmt::format("at most {}", kMaxFieldSamples)});
  for (size_t i = 0; i < n; ++i)
    samples.position.push_back({positions.values[3 * i], positions.values[3 * i + 1], positions.values[3 * i + 2]});
  std::vector<double>* const numbers[] = {&samples.E, &samples.nu, &samples.rho};
  for (int k = 0; k < 3; ++k) {
    Array& array = arrays.at(kNumberNames[k]);
    const bool column = array.shape.size() == 2 && array.shape[1] == 1;
    if ((array.shape.size() != 1 && !column) || array.shape[0] != n)
      throw invalid_input({file, kNumberNames[k], "shape " + shape_text(array.shape),
                           fmt::format("shape [{}], one number per position", n)});
    *numbers[k] = std::move(array.values);
  }
  return samples;
}

void check_samples(const MaterialSamples& samples, const std::string& file) {
  if (samples.position.empty()) throw invalid_input({file, "", "no samples", "at least one"});
  for (size_t i = 0; i < samples.position.size(); ++i) {
    const Eigen::Vector3d& p = samples.position[i];
    if (!(p.array().abs() <= kFarthest).all())
      throw invalid_input({file, "positions", fmt::format("({}, {}, {}) of sample {}", p.x(), p.y(), p.z(), i),
                           "three finite coordinates"});
    const std::string fault = sample_fault(samples.E[i], samples.nu[i], samples.rho[i]);
    if (!fault.empty())
      throw invalid_input(
          {file, "", fmt::format("{} in sample {}", fault, i), "E and density above 0, Poisson's ratio from 0 to 0.5"});
  }
}

}  // namespace

MaterialSamples parse_material_samples(const std::string& bytes, const std::string& file) {
  const char* const expected = "a material field: .npz, or .usda as text";
  MaterialSamples samples;
  if (ZipArchive::is_zip(bytes)) {
    const ZipArchive zip(bytes, file);
    for (const std::string& name : zip.names()) {
      if (name.find(".usd") != std::string::npos)
        throw invalid_input({file, "", "a USD package (.usdz)", expected, "usdcat --flatten in.usdz -o out.usda"});
    }
    samples = samples_of_arrays(
        parse_arrays(bytes, file, {"positions", kNumberNames[0], kNumberNames[1], kNumberNames[2]}), file);
  } else if (is_usda(bytes)) {
    samples = parse_usda_samples(bytes, file);
  } else if (bytes.compare(0, 8, "PXR-USDC") == 0) {
    throw invalid_input(
        {file, "", "a binary USD crate (.usdc)", expected, "usdcat --flatten in.usdc -o out.usda makes text of it"});
  } else {
    throw invalid_input({file, "", "another kind of file", expected});
  }
  check_samples(samples, file);
  return samples;
}

MaterialSamples load_material_samples(const std::string& path) {
  return parse_material_samples(read_file(path, kMaxMaterialFile), path);
}

MaterialField placed_samples(const MaterialSamples& samples, const Eigen::Vector3d& offset,
                             const Eigen::Matrix3d& turn) {
  MaterialField field;
  field.position.reserve(samples.position.size());
  for (const Eigen::Vector3d& p : samples.position) field.position.push_back((turn * (p - offset)).cast<float>());
  field.E.assign(samples.E.begin(), samples.E.end());
  field.nu.assign(samples.nu.begin(), samples.nu.end());
  field.rho.assign(samples.rho.begin(), samples.rho.end());
  return field;
}

}  // namespace physmas::bundle
