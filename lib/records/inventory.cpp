#include "records/inventory.h"

#include <set>

#include "records/json.h"

namespace physmas {
namespace {

AppearanceHints hints_from(const Json& json) {
  AppearanceHints hints;
  if (!json.contains("hints")) return hints;
  const Json& h = json.at("hints");
  for (const Json& color : h.value("colors", Json::array())) hints.colors.push_back(vector3_from(color));
  hints.tolerance = h.value("tolerance", hints.tolerance);
  if (h.contains("regions")) {
    for (const auto& [view, polygons] : h.at("regions").items()) {
      for (const Json& polygon : polygons) {
        std::vector<Eigen::Vector2d> points;
        for (const Json& point : polygon) points.emplace_back(point[0].get<double>(), point[1].get<double>());
        hints.regions[view].push_back(std::move(points));
      }
    }
  }
  return hints;
}

void add_hints(Json& json, const AppearanceHints& hints) {
  if (hints.empty()) return;
  Json h;
  if (!hints.colors.empty()) {
    h["colors"] = Json::array();
    for (const Eigen::Vector3d& color : hints.colors) h["colors"].push_back(to_json(color));
    h["tolerance"] = hints.tolerance;
  }
  for (const auto& [view, polygons] : hints.regions) {
    for (const auto& polygon : polygons) {
      Json points = Json::array();
      for (const Eigen::Vector2d& p : polygon) points.push_back(Json::array({p.x(), p.y()}));
      h["regions"][view].push_back(points);
    }
  }
  json["hints"] = h;
}

}  // namespace

int Inventory::find_object(const std::string& id) const {
  for (size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

int Inventory::find_row(const std::string& key) const {
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].key() == key) return static_cast<int>(i);
  }
  return -1;
}

std::vector<std::string> Inventory::row_keys() const {
  std::vector<std::string> keys;
  for (const InventoryRow& row : rows) keys.push_back(row.key());
  return keys;
}

std::vector<bool> Inventory::residual_rows() const {
  std::vector<bool> residual;
  for (const InventoryRow& row : rows) residual.push_back(row.residual);
  return residual;
}

Inventory load_inventory(const std::string& path) {
  const Json document = load_record(path, "inventory");
  Inventory inventory;
  std::set<std::string> ids, keys, with_rows, with_residual;
  for (const Json& json : document.at("objects")) {
    InventoryObject object;
    object.id = json.at("id").get<std::string>();
    object.name = json.at("name").get<std::string>();
    object.scene_role = json.value("scene_role", "");
    for (const Json& query : json.value("queries", Json::array())) {
      object.queries.push_back({query.at("view").get<std::string>(), query.at("text").get<std::string>()});
    }
    object.hints = hints_from(json);
    if (!ids.insert(object.id).second) {
      throw invalid_field(path, "/objects/" + std::to_string(inventory.objects.size()) + "/id", json.at("id"),
                          "an id that no other object has");
    }
    inventory.objects.push_back(std::move(object));
  }
  for (const Json& json : document.at("rows")) {
    const std::string pointer = "/rows/" + std::to_string(inventory.rows.size());
    InventoryRow row;
    row.object = json.at("object").get<std::string>();
    row.part = json.at("part").get<std::string>();
    row.name = json.at("name").get<std::string>();
    row.structural_role = json.value("structural_role", "");
    row.physics_group = json.value("physics_group", "");
    row.named_by_prompt = json.value("named_by", "") == "prompt";
    row.expected_labels = json.value("expected_labels", std::vector<std::string>());
    row.evidence_refs = json.value("evidence_refs", std::vector<std::string>());
    row.residual = json.value("residual", false);
    row.hints = hints_from(json);
    if (ids.count(row.object) == 0)
      throw invalid_field(path, pointer + "/object", json.at("object"), "the id of an object in /objects");
    if (!keys.insert(row.key()).second)
      throw invalid_field(path, pointer + "/part", json.at("part"), "a part id that no other row of this object has");
    if (row.residual && !with_residual.insert(row.object).second)
      throw invalid_field(path, pointer + "/residual", true, "one residual row per object");
    with_rows.insert(row.object);
    inventory.rows.push_back(std::move(row));
  }
  for (const InventoryObject& object : inventory.objects) {
    if (with_rows.count(object.id) == 0)
      throw invalid_input({path, "/rows", "no row of object \"" + object.id + "\"", "at least one row per object"});
  }
  return inventory;
}

void save_inventory(const std::string& path, const Inventory& inventory, const std::vector<Omission>& omitted,
                    const Provenance& provenance, const std::vector<ExchangeReference>& exchanges) {
  Json json;
  json["objects"] = Json::array();
  for (const InventoryObject& object : inventory.objects) {
    Json entry;
    entry["id"] = object.id;
    entry["name"] = object.name;
    entry["scene_role"] = object.scene_role;
    entry["queries"] = Json::array();
    for (const InventoryObject::Query& query : object.queries)
      entry["queries"].push_back({{"view", query.view}, {"text", query.text}});
    add_hints(entry, object.hints);
    json["objects"].push_back(entry);
  }
  json["rows"] = Json::array();
  for (const InventoryRow& row : inventory.rows) {
    Json entry;
    entry["object"] = row.object;
    entry["part"] = row.part;
    entry["name"] = row.name;
    entry["structural_role"] = row.structural_role;
    entry["physics_group"] = row.physics_group;
    if (row.named_by_prompt) entry["named_by"] = "prompt";
    entry["expected_labels"] = row.expected_labels;
    entry["evidence_refs"] = row.evidence_refs;
    entry["residual"] = row.residual;
    add_hints(entry, row.hints);
    json["rows"].push_back(entry);
  }
  if (!exchanges.empty()) json["exchanges"] = to_json(exchanges);
  json["omitted"] = to_json(omitted);
  save_record(path, "inventory", provenance, json);
}

}  // namespace physmas
