#include "plan/one_part.h"

#include <algorithm>

namespace physmas::plan {
namespace {

// The object's own mask in a view, else everything inside one of its parts, with their mean confidence.
Mask whole_mask(const Inventory& inventory, const ViewMasks& view, size_t object) {
  if (view.objects[object].area() > 0) return view.objects[object];
  Mask whole;
  int count = 0;
  double confidence = 0;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const Mask& part = view.rows[r];
    if (inventory.object_of_row(static_cast<int>(r)) != static_cast<int>(object) || part.area() == 0) continue;
    if (whole.empty()) whole = part;
    for (size_t p = 0; p < part.pixels.size(); ++p) whole.pixels[p] |= part.pixels[p];
    confidence += part.confidence;
    ++count;
  }
  if (count > 0) whole.confidence = confidence / count;
  return whole;
}

InventoryRow whole_row(const Inventory& inventory, const InventoryObject& object) {
  InventoryRow whole;
  whole.object = object.id;
  whole.part = "whole";
  whole.name = object.name;
  whole.structural_role = object.scene_role;
  for (const InventoryRow& row : inventory.rows) {
    if (row.object != object.id || row.residual) continue;
    for (const std::string& label : row.expected_labels) {
      if (std::find(whole.expected_labels.begin(), whole.expected_labels.end(), label) == whole.expected_labels.end())
        whole.expected_labels.push_back(label);
    }
  }
  return whole;
}

void collapse_reference(std::string& reference, Plan& plan) {
  const size_t slash = reference.find('/');
  if (slash == std::string::npos) return;
  plan.corrections.push_back(reference + " became " + reference.substr(0, slash) +
                             ": the run has no object-part state (ablation.object_part_state)");
  reference.resize(slash);
}

}  // namespace

void collapse_parts(Inventory& inventory, std::vector<ViewMasks>& views, Plan& plan) {
  std::vector<InventoryRow> rows;
  std::vector<std::vector<Mask>> masks(views.size());
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    rows.push_back(whole_row(inventory, inventory.objects[o]));
    for (size_t v = 0; v < views.size(); ++v) masks[v].push_back(whole_mask(inventory, views[v], o));
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (!inventory.rows[r].residual) continue;
    rows.push_back(inventory.rows[r]);
    for (size_t v = 0; v < views.size(); ++v) masks[v].push_back(views[v].rows[r]);
  }
  inventory.rows = std::move(rows);
  for (size_t v = 0; v < views.size(); ++v) views[v].rows = std::move(masks[v]);
  for (PlanAction& action : plan.actions) {
    collapse_reference(action.target, plan);
    collapse_reference(action.source, plan);
    // A part that moves against another part of its object has become the object that moves.
    if (action.source == action.target) action.source.clear();
  }
}

}  // namespace physmas::plan
