// evidence.json: material evidence psi_r per row with every intermediate, and the whole-object record.
#ifndef PHYSMAS_RECORDS_EVIDENCE_H
#define PHYSMAS_RECORDS_EVIDENCE_H

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "records/json.h"
#include "records/labels.h"

namespace physmas {

// Label index -> score, in insertion order.
using LabelScores = std::vector<std::pair<int, double>>;
// {label: score}, same order.
Json scores_json(const LabelScores& scores);

// What the user says that a row is; empty: not said. As it stands, whatever the ranges of labels.
struct StatedMaterial {
  std::optional<int> label;   // index into kLabels
  std::optional<double> E;    // Pa of solver space
  std::optional<double> nu;   // 0 <= nu < 0.5
  std::optional<double> rho;  // kg/m^3
  bool empty() const { return !label && !E && !nu && !rho; }
};
StatedMaterial stated_from(const Json& row);
Json to_json(const StatedMaterial& stated);

struct EvidenceRow {
  struct Guard {
    std::string name;  // expected | multi-view | elastic-solid | stated
    bool applied = false;
    int label = 0;                   // the label after this guard
    Json measured = Json::object();  // every value that the guard compared
  };
  // What a material field says of the row's particles, inside the domain of the row's label.
  struct Field {
    struct Range {
      double least = 0, median = 0, most = 0;
      long clamped = 0;  // particles whose sample lies outside the domain
    };
    long particles = 0;  // of the row
    long sampled = 0;    // of them near a sample, at least one
    Range E, nu, rho;    // Pa, 1, kg/m^3
  };
  std::string key;
  bool residual = false;
  long gaussians = 0;
  Json observations;  // material_records form: crops, vlm; null when there are none
  StatedMaterial stated;
  std::vector<int> expected_labels;                          // canonical, deduplicated, in order
  std::vector<std::pair<std::string, LabelScores>> sources;  // schema, crop, vlm, role, whole
  LabelScores role_lookup;                                   // R_r
  LabelScores scores;                                        // s_r
  bool fallback = false;
  std::vector<std::pair<int, double>> posterior;  // fourteen, stored posterior order
  std::vector<Guard> guards;
  int label = 0;                         // m_r
  double confidence = 0;                 // P_r(m_r)
  double log10_E = 0, E_dispersion = 0;  // e_post, sigma^e
  double E_mean = 0, E_spread = 0;       // e-bar, s^e
  double E_uncertainty = 0;              // a-bar
  int E_records = 0;
  double nu = 0, nu_dispersion = 0;  // nu_post, sigma^nu
  double nu_mean = 0;
  double nu_uncertainty = 0;  // sigma-bar^nu
  int nu_records = 0;
  double entropy = 0;          // H_r
  double mask_confidence = 0;  // gamma^mask, 0: unavailable
  double part_confidence = 0;  // gamma^part
  std::optional<Field> field;
  // P_r(label), 0 for a label that is not there.
  double probability(int label) const;
};

// The auxiliary whole-object record (beta_g, E_g, nu_g, rho_g).
struct WholeObject {
  std::string source = "fallback";  // fallback | crop | authored
  int label = -1;                   // -1: none
  Branch branch = Branch::plasticine;
  double E = 5e5, nu = 0.476, rho = 5000;  // the paper's fixed fallback
  Json crops = nullptr;                    // material_records form; null when there are none
};

struct Evidence {
  std::vector<EvidenceRow> rows;  // inventory order, every row
  WholeObject whole_object;
  std::vector<ExchangeReference> exchanges;
  std::vector<Omission> omitted;
};

// row_keys: the keys that the record must have, in this order (inventory.rows).
Evidence load_evidence(const std::string& path, const std::vector<std::string>& row_keys);
void save_evidence(const std::string& path, const Evidence& evidence, const Provenance& provenance);

}  // namespace physmas

#endif
