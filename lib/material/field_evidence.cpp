#include "material/field_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "records/particle_material.h"

namespace physmas::material {
namespace {

EvidenceRow::Field::Range range_of(std::vector<double>& values, long clamped) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return {*least, *middle, *most, clamped};
}

}  // namespace

void take_field(Evidence& evidence, const State& state) {
  if (state.field.empty()) return;
  struct Values {
    std::vector<double> E, nu, rho;
    long particles = 0, E_clamped = 0, nu_clamped = 0, rho_clamped = 0;
  };
  std::vector<Values> rows(evidence.rows.size());
  for (size_t q = 0; q < state.particle_count(); ++q) {
    Values& row = rows[state.row[q]];
    ++row.particles;
    if (!state.field.has_sample(q)) continue;
    const ParticleNumbers sample = {state.field.E[q], state.field.nu[q], state.field.rho[q]};
    const ParticleNumbers inside = material_domain(evidence.rows[state.row[q]].label).clamped(sample);
    row.E.push_back(inside.E), row.nu.push_back(inside.nu), row.rho.push_back(inside.rho);
    row.E_clamped += inside.E != sample.E;
    row.nu_clamped += inside.nu != sample.nu;
    row.rho_clamped += inside.rho != sample.rho;
  }
  for (size_t r = 0; r < rows.size(); ++r) {
    Values& values = rows[r];
    if (values.E.empty()) continue;
    EvidenceRow& row = evidence.rows[r];
    row.field = {values.particles, static_cast<long>(values.E.size()), range_of(values.E, values.E_clamped),
                 range_of(values.nu, values.nu_clamped), range_of(values.rho, values.rho_clamped)};
    row.log10_E = std::log10(row.field->E.median);
    row.nu = row.field->nu.median;
  }
}

std::string field_line(const EvidenceRow& row) {
  constexpr double kWorthSaying = 0.05;
  const EvidenceRow::Field& field = *row.field;
  const LabelPrior& label = kLabels[row.label];
  std::string line =
      fmt::format("{}: the material field has {:.0f} % of its particles, E {:.3g} to {:.3g} Pa, median {:.3g}", row.key,
                  100.0 * static_cast<double>(field.sampled) / static_cast<double>(field.particles), field.E.least,
                  field.E.most, field.E.median);
  const double share = static_cast<double>(field.E.clamped) / static_cast<double>(field.sampled);
  if (share >= kWorthSaying) {
    line += fmt::format(
        "; E of {:.0f} % of them was outside the {:.3g} to {:.3g} Pa of {} and taken at its end: --material "
        "(MATERIAL=) says what it is made of",
        100 * share, label.E_lo, label.E_hi, label.name);
  }
  return line;
}

}  // namespace physmas::material
