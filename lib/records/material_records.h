// The file that `pm-material --predictor FILE` reads: crop predictions, vision-language answers, authored values.
#ifndef PHYSMAS_RECORDS_MATERIAL_RECORDS_H
#define PHYSMAS_RECORDS_MATERIAL_RECORDS_H

#include <optional>
#include <string>
#include <vector>

#include "records/evidence.h"
#include "records/inventory.h"

namespace physmas {

// One crop j of a row. Empty: absent or not finite. At most one of the normalised and the physical value is there.
struct CropRecord {
  bool valid = true;
  std::optional<double> E_mean, nu_mean;  // normalised model outputs mu^E, mu^nu
  std::optional<double> E, nu;            // Pa of solver space; Poisson's ratio
  std::optional<double> E_uncertainty;    // log10 Pa
  std::optional<double> nu_uncertainty;   // units of nu
  LabelScores evidence;                   // e^phys, record order, >= 0
};

// One answer of a vision-language model about a row.
struct VlmRecord {
  bool success = false;
  bool abstain = false;
  std::optional<double> confidence;  // 0..1
  std::vector<std::string> views;
  LabelScores probabilities;  // record order, >= 0, not yet normalised
};

struct RowObservations {
  std::vector<CropRecord> crops;
  std::vector<VlmRecord> vlm;
  StatedMaterial stated;
};

struct WholeObjectObservations {
  int label = -1;  // -1: the crops select it
  std::vector<CropRecord> crops;
};

struct MaterialRecords {
  std::vector<RowObservations> rows;  // [inventory.rows]
  std::optional<WholeObjectObservations> whole_object;
  // Whether anything was observed, beside what is stated.
  bool has_observations() const;
};

// Labels are read without case; an unknown label, a label twice, an unknown row key or a row twice is an Error (exit
// code 3).
MaterialRecords load_material_records(const std::string& path, const Inventory& inventory);

// What is known of the whole object is known of its only part: where the records name no row and the inventory has one
// semantic row, that row takes the crops of the whole object.
void share_with_only_row(MaterialRecords& records, const Inventory& inventory);

// The observations as the record writes them.
Json to_json(const std::vector<CropRecord>& crops);
Json to_json(const std::vector<VlmRecord>& answers);

// Appends what `more` has to `records`, row by row; a whole-object record, and what is stated of a row, are taken where
// there was none.
void append_records(MaterialRecords& records, const MaterialRecords& more);

}  // namespace physmas

#endif
