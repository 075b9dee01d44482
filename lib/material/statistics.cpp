#include "material/statistics.h"

#include <algorithm>
#include <cmath>

#include "material/label_scores.h"
#include "records/json.h"

namespace physmas::material {
namespace {

constexpr double kWeightFloor = 0.05, kWeightAbsent = 0.1;
constexpr double kSpreadFloor = 0.25;                       // s^e, also with fewer than two E records
constexpr double kDefaultE_uncertainty = 0.35;              // a-bar without E records
constexpr double kDefaultNu_uncertainty = 0.06;             // sigma-bar^nu without any
constexpr double kEntropyCap = 0.5;                         // h_r
constexpr double kMaskUnavailable = 0.7, kMaskFloor = 0.2;  // gamma^mask
constexpr double kWholeNu_lo = 0.05, kWholeNu_hi = 0.485;   // backend guard of the whole-object record
constexpr double kWholeRho_lo = 100, kWholeRho_hi = 7800;   // kg/m^3

double clip(double x, double lo, double hi) {
  return std::min(std::max(x, lo), hi);
}

// w_rj: the crop's evidence for the selected label, floored.
double weight_of(const CropRecord& crop, int label) {
  return contains(crop.evidence, label) ? std::max(kWeightFloor, value(crop.evidence, label)) : kWeightAbsent;
}

// Weighted values of the records that are finite for one statistic.
struct Pool {
  std::vector<double> x, w, uncertainty;

  double mean() const { return weighted(x); }
  double variance() const {
    const double center = mean();
    std::vector<double> squares;
    for (double value : x) squares.push_back((value - center) * (value - center));
    return weighted(squares);
  }
  double mean_uncertainty(double fallback) const {
    double sum = 0;
    for (double a : uncertainty) sum += a;
    return uncertainty.empty() ? fallback : sum / uncertainty.size();
  }

 private:
  double weighted(const std::vector<double>& values) const {
    double sum = 0, total = 0;
    for (size_t i = 0; i < values.size(); ++i) sum += w[i] * values[i], total += w[i];
    return sum / total;
  }
};

// L^E: a record needs a finite log E and a finite uncertainty.
Pool E_pool(const std::vector<CropRecord>& crops, int label) {
  Pool pool;
  for (const CropRecord& crop : crops) {
    const std::optional<double> x = decoded_log10_E(crop);
    if (!crop.valid || !x || !crop.E_uncertainty) continue;
    pool.x.push_back(*x);
    pool.w.push_back(weight_of(crop, label));
    pool.uncertainty.push_back(*crop.E_uncertainty);
  }
  return pool;
}

// L^nu: a record needs a finite nu; its uncertainty is averaged where there is one.
Pool nu_pool(const std::vector<CropRecord>& crops, int label) {
  Pool pool;
  for (const CropRecord& crop : crops) {
    const std::optional<double> x = decoded_nu(crop);
    if (!crop.valid || !x) continue;
    pool.x.push_back(*x);
    pool.w.push_back(weight_of(crop, label));
    if (crop.nu_uncertainty) pool.uncertainty.push_back(*crop.nu_uncertainty);
  }
  return pool;
}

std::optional<double> if_finite(double x) {
  return std::isfinite(x) ? std::optional<double>(x) : std::nullopt;
}

// Arg max of the averaged crop evidence, insertion order breaking ties; -1 when there is none.
int averaged_label(const std::vector<CropRecord>& crops) {
  LabelScores sums;
  for (const CropRecord& crop : crops) {
    if (!crop.valid) continue;
    for (const auto& [label, score] : crop.evidence) entry(sums, label) += score;
  }
  int best = -1;
  for (const auto& [label, score] : sums) {
    if (score > 0 && (best < 0 || score > value(sums, best))) best = label;
  }
  return best;
}

}  // namespace

std::optional<double> decoded_log10_E(const CropRecord& crop) {
  if (crop.E) return if_finite(std::log10(*crop.E));
  if (!crop.E_mean) return std::nullopt;
  return if_finite(std::log10(0.1 * std::pow(10.0, 2.456477 * *crop.E_mean + 7.387210)));
}

std::optional<double> decoded_nu(const CropRecord& crop) {
  if (crop.nu) return if_finite(*crop.nu);
  if (!crop.nu_mean) return std::nullopt;
  return if_finite(0.111 * *crop.nu_mean + 0.398);
}

void pool_statistics(EvidenceRow& evidence, const std::vector<CropRecord>& crops) {
  const LabelPrior& prior = kLabels[evidence.label];
  const Pool E = E_pool(crops, evidence.label), nu = nu_pool(crops, evidence.label);

  evidence.E_records = static_cast<int>(E.x.size());
  evidence.E_mean = E.x.empty() ? std::log10(prior.E_default()) : E.mean();
  evidence.E_spread = E.x.size() < 2 ? kSpreadFloor : std::max(kSpreadFloor, std::sqrt(E.variance()));
  evidence.E_uncertainty = E.mean_uncertainty(kDefaultE_uncertainty);
  evidence.log10_E = std::log10(prior.clip_E(std::pow(10.0, evidence.E_mean)));
  const double h = std::min(kEntropyCap, evidence.entropy / std::max(1.0, std::log(double{kLabelCount})));
  evidence.E_dispersion = std::max(0.10, 0.50 * evidence.E_uncertainty + 0.35 * evidence.E_spread + 0.15 * h);

  evidence.nu_records = static_cast<int>(nu.x.size());
  evidence.nu_mean = nu.x.empty() ? prior.nu_default() : nu.mean();
  evidence.nu_uncertainty = nu.mean_uncertainty(kDefaultNu_uncertainty);
  evidence.nu = prior.clip_nu(evidence.nu_mean);
  evidence.nu_dispersion = std::max(0.02, evidence.nu_uncertainty);

  // Eq. supp-maskconfidence
  const double mask = evidence.mask_confidence > 0 ? evidence.mask_confidence : kMaskUnavailable;
  evidence.part_confidence = clip(evidence.confidence / (1 + evidence.E_dispersion) * std::max(kMaskFloor, mask), 0, 1);
}

WholeObject whole_object_record(const std::optional<WholeObjectObservations>& observations) {
  WholeObject whole;
  if (!observations) return whole;
  const int label = observations->label >= 0 ? observations->label : averaged_label(observations->crops);
  if (label < 0) return whole;
  const LabelPrior& prior = kLabels[label];
  const Pool E = E_pool(observations->crops, label), nu = nu_pool(observations->crops, label);
  whole.source = observations->label >= 0 ? "authored" : "crop";
  whole.label = label;
  whole.branch = prior.branch;
  whole.E = prior.clip_E(E.x.empty() ? prior.E_default() : std::pow(10.0, E.mean()));
  whole.nu = clip(prior.clip_nu(nu.x.empty() ? prior.nu_default() : nu.mean()), kWholeNu_lo, kWholeNu_hi);
  whole.rho = clip(prior.rho, kWholeRho_lo, kWholeRho_hi);
  if (!observations->crops.empty()) whole.crops = to_json(observations->crops);
  return whole;
}

}  // namespace physmas::material
