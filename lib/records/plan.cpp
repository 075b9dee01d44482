#include "records/plan.h"

#include "records/json.h"
#include "records/names.h"

namespace physmas {

std::vector<int> resolve_rows(const Inventory& inventory, const std::string& reference) {
  std::vector<int> rows;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].object == reference || inventory.rows[r].key() == reference)
      rows.push_back(static_cast<int>(r));
  }
  return rows;
}

std::vector<PlanAction> actions_from(const Json& list, const Inventory& inventory, const std::string& path) {
  std::vector<PlanAction> actions;
  for (const Json& json : list) {
    const std::string pointer = "/actions/" + std::to_string(actions.size());
    PlanAction action;
    action.type = action_from(json.at("type").get<std::string>());
    if (!json.at("source").is_null()) action.source = json.at("source").get<std::string>();
    action.target = json.at("target").get<std::string>();
    action.direction = vector3_from(json.at("direction"));
    action.magnitude = json.at("magnitude").get<double>();
    action.start = json.at("start").get<double>();
    action.end = json.at("end").get<double>();
    action.role = json.at("role").get<std::string>();
    action.impact = json.at("impact").get<bool>();
    action.slab = json.value("region", "whole") == "slab";
    action.follow = static_cast<Follow>(index_of(kFollowNames, json.value("follow", "none")));
    if (action.end < action.start) throw invalid_field(path, pointer + "/end", action.end, "a time at or after /start");
    if (std::abs(action.direction.norm() - 1) > 1e-6)
      throw invalid_field(path, pointer + "/direction", json.at("direction"), "a unit vector");
    for (const char* field : {"source", "target"}) {
      const std::string& reference = field[0] == 's' ? action.source : action.target;
      if (!reference.empty() && resolve_rows(inventory, reference).empty()) {
        throw invalid_field(path, pointer + "/" + field, reference, "an object id or a row key of the inventory");
      }
    }
    actions.push_back(std::move(action));
  }
  return actions;
}

Plan load_plan(const std::string& path, const Inventory& inventory) {
  const Json document = load_record(path, "plan");
  Plan plan;
  plan.prompt = document.at("prompt").get<std::string>();
  plan.resolved = document.at("resolved").get<bool>();
  plan.actions = actions_from(document.at("actions"), inventory, path);
  for (const Json& json : document.value("materials", Json::array())) {
    const std::string target = json.at("target").get<std::string>();
    if (resolve_rows(inventory, target).empty()) {
      throw invalid_field(path, "/materials/" + std::to_string(plan.materials.size()) + "/target", target,
                          "an object id or a row key of the inventory");
    }
    plan.materials.push_back(
        {target, *find_label(json.at("label").get<std::string>()), json.at("word").get<std::string>()});
  }
  plan.still = document.value("still", false);
  plan.proposal = document.at("proposal");
  plan.corrections = document.at("corrections").get<std::vector<std::string>>();
  plan.omitted = omissions_from(document);
  return plan;
}

void save_plan(const std::string& path, const Plan& plan, const Provenance& provenance) {
  Json json;
  json["prompt"] = plan.prompt;
  json["resolved"] = plan.resolved;
  json["actions"] = Json::array();
  for (const PlanAction& action : plan.actions) {
    Json entry;
    entry["type"] = action_name(action.type);
    entry["source"] = action.source.empty() ? Json() : Json(action.source);
    entry["target"] = action.target;
    entry["direction"] = to_json(action.direction);
    entry["magnitude"] = action.magnitude;
    entry["start"] = action.start;
    entry["end"] = action.end;
    entry["role"] = action.role;
    entry["impact"] = action.impact;
    if (action.slab) entry["region"] = "slab";
    if (action.follow != Follow::none) entry["follow"] = kFollowNames[static_cast<int>(action.follow)];
    json["actions"].push_back(entry);
  }
  if (!plan.materials.empty()) json["materials"] = Json::array();
  for (const PlanMaterial& material : plan.materials) {
    json["materials"].push_back(
        {{"target", material.target}, {"label", kLabels[material.label].name}, {"word", material.word}});
  }
  if (plan.still) json["still"] = true;
  json["proposal"] = plan.proposal;
  json["corrections"] = plan.corrections;
  json["omitted"] = to_json(plan.omitted);
  save_record(path, "plan", provenance, json);
}

}  // namespace physmas
