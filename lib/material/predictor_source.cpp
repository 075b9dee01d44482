#include "material/predictor_source.h"

#include <fmt/format.h>

#include <cmath>

#include "scene/image_file.h"

namespace physmas::material {
namespace {

const std::vector<std::string> kOutputs = {"E_mean", "E_uncertainty", "nu_mean", "nu_uncertainty", "label_evidence"};

std::vector<CropRecord> predict(remote::InferenceClient& predictor, const std::string& name,
                                const std::vector<std::string>& crops) {
  if (crops.empty()) return {};
  const long n = static_cast<long>(crops.size());
  std::vector<remote::TensorSpecification> outputs;
  for (const std::string& output : kOutputs) outputs.push_back({output, {n}, true});
  outputs.back().shape.push_back(kLabelCount);
  return crops_from_tensors(predictor.infer(name, {{"crops", {n}, crops, {}, {}}}, outputs), name);
}

}  // namespace

std::vector<CropRecord> crops_from_tensors(const std::map<std::string, remote::Tensor>& tensors,
                                           const std::string& source) {
  std::vector<CropRecord> crops(tensors.at("E_mean").numbers.size());
  const auto number = [&](const std::string& output, size_t i, bool may_be_negative) -> std::optional<double> {
    const double x = tensors.at(output).numbers[i];
    if (!may_be_negative && x < 0)
      throw remote::provider_error(
          source, fmt::format("/outputs/{}/data/{}: found {}, expected no negative number", output, i, x));
    return std::isfinite(x) ? std::optional<double>(x) : std::nullopt;
  };
  for (size_t i = 0; i < crops.size(); ++i) {
    crops[i].E_mean = number("E_mean", i, true);
    crops[i].E_uncertainty = number("E_uncertainty", i, false);
    crops[i].nu_mean = number("nu_mean", i, true);
    crops[i].nu_uncertainty = number("nu_uncertainty", i, false);
    for (int label = 0; label < kLabelCount; ++label) {
      if (const auto score = number("label_evidence", i * kLabelCount + label, false))
        crops[i].evidence.emplace_back(label, *score);
    }
  }
  return crops;
}

MaterialRecords predict_rows(remote::InferenceClient& predictor, const Inventory& inventory,
                             const std::vector<ViewPicture>& pictures, const std::vector<ViewMasks>& masks) {
  predictor.require_model({"crops"}, kOutputs);
  MaterialRecords records;
  records.rows.resize(inventory.rows.size());
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const InventoryRow& row = inventory.rows[r];
    if (row.residual) continue;
    std::vector<std::string> crops;
    for (size_t v = 0; v < masks.size(); ++v) {
      const Mask& mask = masks[v].rows[r];
      if (mask.area() > 0) crops.push_back(encode_png(masked_crop(pictures[v], mask)));
    }
    records.rows[r].crops = predict(predictor, row.object + "_" + row.part, crops);
  }
  std::vector<std::string> crops;
  for (size_t v = 0; v < masks.size(); ++v) {
    Mask whole = union_of(masks[v].objects);
    if (whole.area() == 0) whole = union_of(masks[v].rows);
    if (whole.area() > 0) crops.push_back(encode_png(masked_crop(pictures[v], whole)));
  }
  if (!crops.empty()) {
    records.whole_object.emplace();
    records.whole_object->crops = predict(predictor, "whole-object", crops);
  }
  return records;
}

}  // namespace physmas::material
