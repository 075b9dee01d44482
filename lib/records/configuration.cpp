#include "records/configuration.h"

#include "records/json.h"

namespace physmas {

AuthoredConfiguration load_configuration(const std::string& path, const Inventory& inventory) {
  const Json document = load_record(path, "configuration");
  const Json& rows = document.at("rows");
  AuthoredConfiguration configuration;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const InventoryRow& row = inventory.rows[r];
    if (row.residual) continue;
    if (!rows.contains(row.key()))
      throw invalid_input({path, "/rows", "no row \"" + row.key() + "\"", "every row of the inventory"});
    const Json& json = rows.at(row.key());
    configuration.rows.push_back({static_cast<int>(r), find_branch(json.at("branch").get<std::string>()).value(),
                                  json.at("E").get<double>(), json.at("nu").get<double>(),
                                  json.at("rho").get<double>()});
  }
  for (const auto& [key, json] : rows.items()) {
    const int r = inventory.find_row(key);
    if (r < 0 || inventory.rows[r].residual)
      throw invalid_field(path, "/rows/" + key, Json(key), "the key of a semantic row of the inventory");
  }
  configuration.actions = actions_from(document.at("actions"), inventory, path);
  if (document.contains("settings")) configuration.settings = document.at("settings").get<std::vector<std::string>>();
  return configuration;
}

}  // namespace physmas
