// The crop source: a physical-property model behind the Open Inference Protocol (docs/providers.md has its tensors).
#ifndef PHYSMAS_MATERIAL_PREDICTOR_SOURCE_H
#define PHYSMAS_MATERIAL_PREDICTOR_SOURCE_H

#include <map>
#include <string>
#include <vector>

#include "material/pictures.h"
#include "records/inventory.h"
#include "records/material_records.h"
#include "remote/inference.h"

namespace physmas::material {

// One inference per semantic row over its crops (one per view that shows it), and one over the crops of all objects
// together for the whole-object record. Errors: exit code 4.
MaterialRecords predict_rows(remote::InferenceClient& predictor, const Inventory& inventory,
                             const std::vector<ViewPicture>& pictures, const std::vector<ViewMasks>& masks);

// The crops of one reply: E_mean, E_uncertainty, nu_mean, nu_uncertainty [N] and label_evidence [N, 14]. NaN means
// absent; negative evidence or uncertainty is an Error (exit code 4). source: for messages.
std::vector<CropRecord> crops_from_tensors(const std::map<std::string, remote::Tensor>& tensors,
                                           const std::string& source);

}  // namespace physmas::material

#endif
