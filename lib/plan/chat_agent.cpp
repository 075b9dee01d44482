#include "plan/chat_agent.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/embedded_text.h"
#include "base/words.h"
#include "plan/action_proposal.h"
#include "plan/scene_inventory.h"
#include "records/json.h"
#include "records/reference.h"
#include "scene/image_file.h"

namespace physmas::plan {
namespace {

// CIELAB distance up to which a colour that the agent names counts: models read colours off pictures coarsely.
constexpr double kNamedColorTolerance = 35;

std::string found_twice(const std::string& pointer, const std::string& id) {
  return fmt::format("{}: found \"{}\" twice, expected every id once", pointer, id);
}

std::vector<std::string> keys_of(const Inventory& inventory) {
  return all_references(inventory);
}

// What the agent is told of an inventory: ids, names and roles, no hints.
Json described(const Inventory& inventory) {
  Json json = {{"objects", Json::array()}, {"rows", Json::array()}};
  for (const InventoryObject& object : inventory.objects)
    json["objects"].push_back({{"id", object.id}, {"name", object.name}, {"scene_role", object.scene_role}});
  for (const InventoryRow& row : inventory.rows) {
    if (row.residual) continue;
    json["rows"].push_back(
        {{"object", row.object}, {"part", row.part}, {"name", row.name}, {"structural_role", row.structural_role}});
  }
  return json;
}

// $.FIELD of an answer as a list of `count` entries.
void give_length(remote::Question& question, const std::string& field, size_t count) {
  question.given.push_back({"/properties/" + field + "/minItems", count});
  question.given.push_back({"/properties/" + field + "/maxItems", count});
}
// FIELD of every entry of $.LIST as one of `values`.
void give_values(remote::Question& question, const std::string& list, const std::string& field,
                 std::vector<std::string> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  question.given.push_back({"/properties/" + list + "/items/properties/" + field, {{"enum", values}}});
}

// An authored inventory keeps its objects and parts.
void give_inventory(remote::Question& question, const Inventory& inventory) {
  std::vector<std::string> objects, parts;
  for (const InventoryObject& object : inventory.objects) objects.push_back(object.id);
  for (const InventoryRow& row : inventory.rows) {
    if (!row.residual) parts.push_back(row.part);
  }
  give_length(question, "objects", objects.size());
  give_length(question, "rows", parts.size());
  give_values(question, "objects", "id", objects);
  give_values(question, "rows", "object", objects);
  give_values(question, "rows", "part", parts);
}

}  // namespace

std::string inventory_rejection(const Json& answer, const Inventory* registered) {
  std::set<std::string> objects, keys, with_rows;
  for (const Json& object : answer.at("objects")) {
    const std::string id = object.at("id").get<std::string>();
    if (!objects.insert(id).second) return found_twice("/objects", id);
  }
  for (const Json& row : answer.at("rows")) {
    const std::string object = row.at("object").get<std::string>(), part = row.at("part").get<std::string>();
    if (objects.count(object) == 0)
      return fmt::format("/rows: found a part of \"{}\", expected the id of one of /objects", object);
    if (part == kResidualPart) return "/rows: found the part id \"residual\", expected another: it is reserved";
    if (!keys.insert(object + "/" + part).second) return found_twice("/rows", object + "/" + part);
    with_rows.insert(object);
  }
  for (const std::string& id : objects) {
    if (with_rows.count(id) == 0) return fmt::format("/rows: found no part of \"{}\", expected at least one", id);
  }
  if (registered == nullptr) return "";
  keys.insert(objects.begin(), objects.end());
  const std::vector<std::string> known = keys_of(*registered);
  for (const std::string& key : keys) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      return fmt::format("/rows: found \"{}\", which the registered inventory does not have, expected {}", key,
                         one_line(join(known)));
  }
  for (const std::string& key : known) {
    if (keys.count(key) == 0) return fmt::format("/rows: found no \"{}\", which the registered inventory has", key);
  }
  return "";
}

std::string query_rejection(const Json& answer, const std::vector<std::string>& keys,
                            const std::vector<std::string>& view_names) {
  std::set<std::string> answered;
  for (const Json& query : answer.at("queries")) {
    const std::string key = query.at("key").get<std::string>();
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      return fmt::format("/queries: found \"{}\", which was not asked about, expected {}", one_line(key, 80),
                         one_line(join(keys)));
    if (!answered.insert(key).second) return found_twice("/queries", key);
    for (const Json& view : query.at("visible_views")) {
      if (std::find(view_names.begin(), view_names.end(), view.get<std::string>()) == view_names.end())
        return fmt::format("/queries: found a view {}, expected {}", one_line(view.dump(), 80), join(view_names));
    }
  }
  for (const std::string& key : keys) {
    if (answered.count(key) == 0) return fmt::format("/queries: found no \"{}\", which was asked about", key);
  }
  return "";
}

Inventory inventory_from_answer(const Json& answer) {
  Inventory inventory;
  for (const Json& json : answer.at("objects")) {
    InventoryObject object;
    object.id = json.at("id").get<std::string>();
    object.name = json.at("name").get<std::string>();
    object.scene_role = json.at("scene_role").get<std::string>();
    inventory.objects.push_back(std::move(object));
  }
  for (const Json& json : answer.at("rows")) {
    InventoryRow row;
    row.object = json.at("object").get<std::string>();
    row.part = json.at("part").get<std::string>();
    row.name = json.at("name").get<std::string>();
    row.structural_role = json.at("structural_role").get<std::string>();
    row.physics_group = json.at("physics_group").get<std::string>();
    row.expected_labels = json.at("expected_labels").get<std::vector<std::string>>();
    inventory.rows.push_back(std::move(row));
  }
  return inventory;
}

std::vector<std::string> ChatAgent::view_names() const {
  std::vector<std::string> names;
  for (const ViewPicture& picture : pictures_) names.push_back(picture.view);
  return names;
}

Json ChatAgent::ask(const remote::Question& question, const std::string& what) {
  const remote::Answer answer = chat_.ask(question);
  for (const std::string& why : answer.rejected) rejected_.push_back({"an answer of the agent about " + what, why});
  return answer.json;
}

Json ChatAgent::propose(const Inventory* registered, Inventory& inventory) {
  const auto inventory_of = [&](const Json& answer) {
    return registered != nullptr ? *registered : inventory_from_answer(answer);
  };
  const SceneGeometry axes = measure_scene(scene_, Inventory(), {});
  remote::Question question;
  question.name = "ground_schema";
  question.instructions = embedded_text("lib/plan/prompts/schema.txt");
  const Json subject = {{"prompt", scene_.prompt},
                        {"front_view", pictures_[0].view},
                        {"views", view_names()},
                        {"duration_s", scene_.run.time.duration()},
                        {"registered_inventory", registered == nullptr ? Json() : described(*registered)}};
  question.text = "The scene: " + subject.dump() + "\nThe front view follows.";
  question.images = {encode_png(pictures_[0].rgb)};
  question.schema = "scene_reply";
  if (registered != nullptr) give_inventory(question, *registered);
  question.reject = [&](const Json& answer) -> std::string {
    const std::string why = inventory_rejection(answer, registered);
    if (!why.empty()) return why;
    // Before perception nothing is known of where things are; that changes directions, not whether the plan resolves.
    try {
      compile_proposal(answer, scene_.prompt, inventory_of(answer), axes, scene_.run);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const Json answer = ask(question, "the scene");
  inventory = inventory_of(answer);
  return answer;
}

Queries ChatAgent::plan_perception(Inventory& inventory, const std::vector<std::string>& missed, const Queries& tried) {
  const std::vector<std::string> keys = missed.empty() ? keys_of(inventory) : missed;
  Json things = Json::array();
  for (const std::string& key : keys) {
    const int o = inventory.find_object(key);
    Json thing = {{"key", key},
                  {"name", o >= 0 ? inventory.objects[o].name : inventory.rows[inventory.find_row(key)].name}};
    thing["missed"] = !missed.empty();
    if (const auto query = tried.find(key); query != tried.end()) thing["tried"] = query->second.text;
    things.push_back(thing);
  }
  remote::Question question;
  question.name = missed.empty() ? "ground_perception" : "ground_repair";
  question.instructions = embedded_text("lib/plan/prompts/perception.txt");
  question.text =
      "The views: " + Json(view_names()).dump() + "\nThe keys: " + things.dump() + "\nThe sheet of views follows.";
  question.images = {encode_png(view_sheet(pictures_))};
  question.schema = "perception_reply";
  give_length(question, "queries", keys.size());
  give_values(question, "queries", "key", keys);
  question.given.push_back({"/properties/queries/items/properties/visible_views/items", {{"enum", view_names()}}});
  question.reject = [&](const Json& answer) { return query_rejection(answer, keys, view_names()); };
  const Json answer = ask(question, missed.empty() ? "the views" : "what the first segmentation missed");
  Queries queries;
  for (const Json& json : answer.at("queries")) {
    const std::string key = json.at("key").get<std::string>();
    Query& query = queries[key];
    query.text = json.at("text").get<std::string>();
    query.views = json.at("visible_views").get<std::vector<std::string>>();
    if (const int o = inventory.find_object(key); o >= 0) {
      inventory.objects[o].queries.clear();
      for (const std::string& view : query.views) inventory.objects[o].queries.push_back({view, query.text});
    }
    // The whole foreground belongs to a scene's only row; objects are the union of their rows.
    const int r = inventory.find_row(key);
    if (r < 0 || keys_of(inventory).size() == 2 || json.at("colors").empty()) continue;
    AppearanceHints& hints = inventory.rows[r].hints;
    // A missed row's colours were wrong or none; authored hints with regions stay.
    if (!hints.empty() && (missed.empty() || !hints.regions.empty())) continue;
    hints.colors.clear();
    for (const Json& color : json.at("colors")) hints.colors.push_back(vector3_from(color) / 255);
    hints.tolerance = kNamedColorTolerance;
  }
  return queries;
}

}  // namespace physmas::plan
