#include "records/state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "records/hdf5_file.h"
#include "records/json.h"
#include "records/material_field.h"

namespace physmas {
namespace {

constexpr uint64_t kMaxParticles = 20000000;
constexpr double kMaxCells = 4096;  // per axis

void check_indices(const Hdf5Reader& file, const char* dataset, const std::vector<int32_t>& values, int32_t limit) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] < 0 || values[i] >= limit) {
      throw file.invalid(dataset, fmt::format("{} at element {}", values[i], i),
                         fmt::format("an index in 0..{}", limit - 1));
    }
  }
}

std::vector<Eigen::Vector3f> read_points(const Hdf5Reader& file, const char* dataset, uint64_t count, double length) {
  const std::vector<float> values = file.read_float(dataset, {count, 3});
  std::vector<Eigen::Vector3f> points(count);
  for (uint64_t q = 0; q < count; ++q) {
    points[q] = {values[3 * q], values[3 * q + 1], values[3 * q + 2]};
    if (points[q].minCoeff() < 0 || points[q].maxCoeff() > length) {
      throw file.invalid(dataset, fmt::format("a position outside the solver cube at element {}", q),
                         fmt::format("0..{} on every axis", length));
    }
  }
  return points;
}

constexpr const char* kCarrierGroup = "/carriers";

// rows: of the Gaussians.
Carriers read_carriers(const Hdf5Reader& file, const std::vector<int32_t>& rows, double length) {
  constexpr int kPer = Carriers::kPerGaussian;
  Carriers carriers;
  if (!file.exists(kCarrierGroup)) return carriers;
  const uint64_t gaussians = rows.size();
  carriers.gaussian = file.read_int("/carriers/gaussian", {UINT64_MAX}, kMaxParticles);
  check_indices(file, "/carriers/gaussian", carriers.gaussian, static_cast<int32_t>(gaussians));
  const int32_t count = static_cast<int32_t>(carriers.gaussian.size());
  if (count == 0) throw file.invalid("/carriers/gaussian", "no carriers", "at least one");
  for (int32_t q = 1; q < count; ++q) {
    if (carriers.gaussian[q] <= carriers.gaussian[q - 1])
      throw file.invalid("/carriers/gaussian",
                         fmt::format("{} after {}", carriers.gaussian[q], carriers.gaussian[q - 1]),
                         "ascending indices");
  }
  carriers.rest = read_points(file, "/carriers/rest", gaussians, length);
  carriers.particle = file.read_int("/carriers/particle", {gaussians, kPer});
  carriers.weight = file.read_float("/carriers/weight", {gaussians, kPer});
  check_indices(file, "/carriers/particle", carriers.particle, count);
  for (uint64_t i = 0; i < gaussians; ++i) {
    double sum = 0;
    for (int k = 0; k < kPer; ++k) {
      const int32_t q = carriers.particle[i * kPer + k];
      if (rows[carriers.gaussian[q]] != rows[i]) {
        throw file.invalid("/carriers/particle", fmt::format("a particle of another row for Gaussian {}", i),
                           "particles of the Gaussian's row");
      }
      const float w = carriers.weight[i * kPer + k];
      if (!(w >= 0)) throw file.invalid("/carriers/weight", fmt::format("{} for Gaussian {}", w, i), "0 or more");
      sum += w;
    }
    if (!(std::abs(sum - 1) < 1e-3)) {
      throw file.invalid("/carriers/weight", fmt::format("weights of a sum of {} for Gaussian {}", sum, i),
                         "a sum of 1");
    }
  }
  return carriers;
}

constexpr const char* kFieldGroup = "/field";

ParticleField read_particle_field(const Hdf5Reader& file, uint64_t particles) {
  ParticleField field;
  if (!file.exists(kFieldGroup)) return field;
  field.E = file.read_float("/field/youngs_modulus", {particles});
  field.nu = file.read_float("/field/poisson_ratio", {particles});
  field.rho = file.read_float("/field/density", {particles});
  field.reach = file.read_attribute(kFieldGroup, "reach", 1)[0];
  if (!(field.reach >= 0)) throw file.invalid("/field/@reach", fmt::format("{}", field.reach), "0 or more");
  for (uint64_t q = 0; q < particles; ++q) {
    if (field.E[q] == 0 && field.nu[q] == 0 && field.rho[q] == 0) continue;
    const std::string fault = sample_fault(field.E[q], field.nu[q], field.rho[q]);
    if (!fault.empty())
      throw file.invalid(kFieldGroup, fmt::format("{} at particle {}", fault, q), "that of a material, or three zeros");
  }
  return field;
}

// A list in a text attribute of the root.
Json list_attribute(const Hdf5Reader& file, const char* name) {
  const Json list = parse_json(file.read_text_attribute("/", name), file.path());
  if (!list.is_array()) throw file.invalid(std::string("/@") + name, one_line(list.dump(), 80), "a list");
  return list;
}

std::string text_of(const Hdf5Reader& file, const char* where, const Json& json) {
  if (!json.is_string()) throw file.invalid(where, one_line(json.dump(), 80), "text");
  return json.get<std::string>();
}

// Of the entry's field; none when the entry is no object or lacks it.
std::string text_of(const Hdf5Reader& file, const char* where, const Json& entry, const char* field) {
  return text_of(file, where, entry.is_object() && entry.contains(field) ? entry.at(field) : Json());
}

}  // namespace

std::vector<long> State::gaussians_per_row() const {
  std::vector<long> counts(row_keys.size(), 0);
  for (int32_t r : gaussian_row) ++counts[r];
  return counts;
}

std::vector<double> State::volume_per_row() const {
  std::vector<double> sums(row_keys.size(), 0);
  for (size_t q = 0; q < particle_count(); ++q) sums[row[q]] += volume[q];
  return sums;
}

namespace {

// Rows of Gaussians and particles, volumes, and the field.
State read_rows(const Hdf5Reader& file, const Inventory* inventory) {
  file.allow_only({"/gaussians/object", "/gaussians/row", "/gaussians/confidence", "/particles/position",
                   "/particles/volume", "/particles/row", "/particles/object", "/particles/source",
                   "/carriers/gaussian", "/carriers/rest", "/carriers/particle", "/carriers/weight",
                   "/field/youngs_modulus", "/field/poisson_ratio", "/field/density"});
  State state;
  const Json keys = list_attribute(file, "rows");
  for (const Json& key : keys) state.row_keys.push_back(text_of(file, "/@rows", key));
  if (inventory != nullptr) {
    if (inventory->row_keys() != state.row_keys) {
      throw file.invalid("/@rows", one_line(keys.dump(), 80),
                         "the rows of the inventory; make the state again with pm-lift");
    }
  }
  const int32_t rows = static_cast<int32_t>(state.row_keys.size());
  state.gaussian_row = file.read_int("/gaussians/row", {UINT64_MAX}, kMaxParticles);
  if (state.gaussian_row.empty()) throw file.invalid("/gaussians/row", "no Gaussians", "at least one");
  state.row = file.read_int("/particles/row", {UINT64_MAX}, kMaxParticles);
  state.volume = file.read_float("/particles/volume", {state.row.size()});
  check_indices(file, "/gaussians/row", state.gaussian_row, rows);
  check_indices(file, "/particles/row", state.row, rows);
  for (size_t q = 0; q < state.volume.size(); ++q) {
    if (!(state.volume[q] > 0))
      throw file.invalid("/particles/volume", fmt::format("{} at particle {}", state.volume[q], q),
                         "a positive volume");
  }
  state.field = read_particle_field(file, state.row.size());
  return state;
}

}  // namespace

State load_state_rows(const std::string& path, const Inventory& inventory) {
  return read_rows(Hdf5Reader(path, "state"), &inventory);
}

State load_state(const std::string& path, const Inventory* inventory) {
  const Hdf5Reader file(path, "state");
  State state = read_rows(file, inventory);
  const int32_t rows = static_cast<int32_t>(state.row_keys.size());
  const uint64_t gaussians = state.gaussian_row.size(), particles = state.row.size();
  state.gaussian_object = file.read_int("/gaussians/object", {gaussians});
  state.gaussian_confidence = file.read_float("/gaussians/confidence", {gaussians});
  state.object = file.read_int("/particles/object", {particles});
  state.source = file.read_int("/particles/source", {particles});
  state.map.s = file.read_attribute("/map", "s", 1)[0];
  const std::vector<double> d = file.read_attribute("/map", "d", 3);
  state.map.d = {d[0], d[1], d[2]};
  state.map.length = file.read_attribute("/map", "L", 1)[0];
  const double cells = file.read_attribute("/map", "n", 1)[0];
  if (!(cells >= 1 && cells <= kMaxCells)) throw file.invalid("/map/@n", fmt::format("{}", cells), "1 to 4096 cells");
  state.map.n = static_cast<int>(cells);
  if (!(state.map.s > 0)) throw file.invalid("/map/@s", fmt::format("{}", state.map.s), "a positive scale");
  if (!(state.map.length > 0)) throw file.invalid("/map/@L", fmt::format("{}", state.map.length), "a positive length");
  check_indices(file, "/particles/source", state.source, static_cast<int32_t>(gaussians));
  const int32_t objects = inventory != nullptr ? static_cast<int32_t>(inventory->objects.size()) : rows;
  check_indices(file, "/gaussians/object", state.gaussian_object, objects);
  check_indices(file, "/particles/object", state.object, objects);
  state.carriers = read_carriers(file, state.gaussian_row, state.map.length);
  const uint64_t carriers = state.carrier_count();
  if (particles < carriers)
    throw file.invalid("/particles/row", fmt::format("{} particles", particles),
                       fmt::format("at least the {} Gaussians", carriers));
  state.position = read_points(file, "/particles/position", particles, state.map.length);
  for (uint64_t q = 0; q < particles; ++q) {
    if (q >= carriers) break;
    const int32_t g = state.carriers.empty() ? static_cast<int32_t>(q) : state.carriers.gaussian[q];
    if (state.source[q] != g || state.row[q] != state.gaussian_row[g]) {
      throw file.invalid("/particles/source", fmt::format("particle {} that is not Gaussian {}", q, g),
                         "the Gaussians first, in file order");
    }
  }
  for (const Json& entry : list_attribute(file, "omitted"))
    state.omitted.push_back({text_of(file, "/@omitted", entry, "what"), text_of(file, "/@omitted", entry, "why")});
  return state;
}

void save_state(const std::string& path, const State& state, const Provenance& provenance) {
  Hdf5Writer file(path, "state", provenance);
  file.write_text_attribute("/", "omitted", compact_text(to_json(state.omitted)));
  file.write_text_attribute("/", "rows", Json(state.row_keys).dump());
  const uint64_t gaussians = state.gaussian_count(), particles = state.particle_count();
  file.write_int("/gaussians/object", {gaussians}, state.gaussian_object.data());
  file.write_int("/gaussians/row", {gaussians}, state.gaussian_row.data());
  file.write_float("/gaussians/confidence", {gaussians}, state.gaussian_confidence.data());
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float), "positions are stored without padding");
  file.write_float("/particles/position", {particles, 3}, state.position.front().data());
  file.write_float("/particles/volume", {particles}, state.volume.data());
  file.write_int("/particles/row", {particles}, state.row.data());
  file.write_int("/particles/object", {particles}, state.object.data());
  file.write_int("/particles/source", {particles}, state.source.data());
  if (!state.carriers.empty()) {
    const Carriers& c = state.carriers;
    file.write_int("/carriers/gaussian", {c.gaussian.size()}, c.gaussian.data());
    file.write_float("/carriers/rest", {gaussians, 3}, c.rest.front().data());
    file.write_int("/carriers/particle", {gaussians, Carriers::kPerGaussian}, c.particle.data());
    file.write_float("/carriers/weight", {gaussians, Carriers::kPerGaussian}, c.weight.data());
  }
  if (!state.field.empty()) {
    file.write_float("/field/youngs_modulus", {particles}, state.field.E.data());
    file.write_float("/field/poisson_ratio", {particles}, state.field.nu.data());
    file.write_float("/field/density", {particles}, state.field.rho.data());
    file.write_attribute(kFieldGroup, "reach", {state.field.reach});
  }
  file.make_group("/map");
  file.write_attribute("/map", "s", {state.map.s});
  file.write_attribute("/map", "d", {state.map.d.x(), state.map.d.y(), state.map.d.z()});
  file.write_attribute("/map", "L", {state.map.length});
  file.write_attribute("/map", "n", {static_cast<double>(state.map.n)});
  file.commit();
}

}  // namespace physmas
