// The JSON loader and the schemas: strict, and clear about what is wrong.
#include "records/json.h"

#include <doctest/doctest.h>

#include <ctime>

#include "base/file.h"
#include "records/candidate.h"
#include "records/inventory.h"
#include "records/plan.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

Json small_inventory() {
  return parse_json(R"({"schema": "physmas/inventory/1",
    "objects": [{"id": "cake", "name": "cake"}],
    "rows": [{"object": "cake", "part": "plate", "name": "plate"}, {"object": "cake", "part": "sponge", "name": "sponge"}]})",
                    "test");
}

// What load_inventory says of a changed inventory.
std::string inventory_error(const std::function<void(Json&)>& change) {
  const TemporaryFolder folder;
  Json json = small_inventory();
  change(json);
  write_file(folder / "i.json", json.dump());
  return message_of([&] { load_inventory(folder / "i.json"); });
}

}  // namespace

TEST_CASE("records: malformed JSON is refused with line and column") {
  CHECK(contains(message_of([] { parse_json("{\n  \"a\": }", "f.json"); }), "f.json: line 2, column 8"));
  CHECK(contains(message_of([] { parse_json("", "f.json"); }), "f.json"));
  CHECK(contains(message_of([] { parse_json("{\"a\": 1e999}", "f.json"); }), "out of range"));
  CHECK(contains(message_of([] { parse_json("{\"a\": NaN}", "f.json"); }), "malformed"));
}

TEST_CASE("records: a number out of range has its place") {
  CHECK(contains(message_of([] { parse_json("{\n \"a\": [1, 1e999]}", "f.json"); }),
                 "f.json: line 2, column 15: found a number out of range, 1e999"));
}

TEST_CASE("records: many keys are refused by their number, and what is read takes time in proportion") {
  const auto object_of = [](int keys) {
    std::string text = "{";
    for (int i = 0; i < keys; ++i) text += (i == 0 ? "\"k" : ",\"k") + std::to_string(i) + "\":" + std::to_string(i);
    return text + "}";
  };
  CHECK(contains(message_of([&] { parse_json(object_of(300000), "f.json"); }), "found more than 4096 keys"));
  const Json most = parse_json(object_of(4096), "f.json");
  CHECK(most.size() == 4096);
  CHECK(most.at("k4095") == 4095);
  // Many objects of many keys: a search for each key took minutes.
  std::string list = "[";
  for (int i = 0; i < 64; ++i) list += (i == 0 ? "" : ",") + object_of(4096);
  const auto start = std::clock();
  CHECK(parse_json(list + "]", "f.json").size() == 64);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  CHECK(seconds < 10);
}

TEST_CASE("records: JSON keeps order and kinds") {
  const std::string text = R"({"b":[1,-2,2.5,true,null,"x",{}],"a":{"z":[],"y":18446744073709551615}})";
  CHECK(parse_json(text, "f").dump() == text);
  for (const char* one : {"1", "\"x\"", "[]", "null"}) CHECK(parse_json(one, "f").dump() == one);
}

TEST_CASE("records: duplicate keys and deep nesting are refused") {
  CHECK(contains(message_of([] { parse_json(R"({"a": {"b": 1, "b": 2}})", "f.json"); }), "same key twice"));
  CHECK(parse_json(R"({"a": {"b": 1}, "c": {"b": 2}})", "f.json").size() == 2);
  CHECK(contains(message_of([] { parse_json(std::string(100, '[') + std::string(100, ']'), "f.json"); }), "deeper"));
}

TEST_CASE("records: the inventory's schema and its references") {
  CHECK(inventory_error([](Json&) {}) == "no error");
  CHECK(
      contains(inventory_error([](Json& j) { j["schema"] = "physmas/plan/1"; }), "/schema: found \"physmas/plan/1\""));
  CHECK(contains(inventory_error([](Json& j) { j.erase("schema"); }), "/schema: found nothing"));
  CHECK(contains(inventory_error([](Json& j) { j["extra"] = 1; }), "unknown field 'extra'"));
  CHECK(contains(inventory_error([](Json& j) { j["rows"][0]["colour"] = 1; }), "/rows/0: found"));
  CHECK(contains(inventory_error([](Json& j) { j["rows"][0]["name"] = 5; }), "/rows/0/name: found 5"));
  CHECK(contains(inventory_error([](Json& j) { j["rows"][1]["part"] = "plate"; }), "/rows/1/part: found \"plate\""));
  CHECK(contains(inventory_error([](Json& j) { j["rows"][1]["object"] = "pie"; }), "/rows/1/object: found \"pie\""));
  CHECK(
      contains(inventory_error([](Json& j) { j["rows"][0]["part"] = "../x"; }),
               "/rows/0/part: found \"../x\", expected what schemas/inventory.json allows; an identifier of lower-case "
               "letters, digits and dashes"));
  CHECK(contains(inventory_error([](Json& j) { j["objects"].push_back(j["objects"][0]); }), "/objects/1/id"));
  CHECK(contains(inventory_error([](Json& j) {
                   j["objects"].push_back({{"id", "pie"}, {"name", "pie"}});
                 }),
                 "no row of object"));
  CHECK(contains(inventory_error([](Json& j) { j["rows"] = Json::array(); }), "/rows"));
}

TEST_CASE("records: an inventory survives saving and loading, hints included") {
  const TemporaryFolder folder;
  Inventory inventory;
  inventory.objects = {{"cake", "a cake", "target", {{"front", "cake"}}, {}}};
  inventory.rows.resize(2);
  inventory.rows[0] = {"cake", "plate", "plate", "support", "rigid", {"Ceramic"}, {}, false, {}};
  inventory.rows[0].hints.colors = {{0.5, 0.25, 1}};
  inventory.rows[0].hints.regions["front"] = {{{0, 0}, {1, 0}, {0.5, 1}}};
  inventory.rows[1] = {"cake", "residual", "residual", "", "", {}, {}, true, {}};
  Provenance provenance;
  provenance.tool = "test";
  save_inventory(folder / "i.json", inventory, {{"nothing", "no reason"}}, provenance);
  const Inventory loaded = load_inventory(folder / "i.json");
  CHECK(loaded.rows[0].hints.colors[0] == Eigen::Vector3d(0.5, 0.25, 1));
  CHECK(loaded.rows[0].hints.regions.at("front")[0][2] == Eigen::Vector2d(0.5, 1));
  CHECK(loaded.rows[1].residual);
  CHECK(loaded.find_row("cake/residual") == 1);
  CHECK(resolve_rows(loaded, "cake") == std::vector<int>{0, 1});
  const std::string bytes = read_file(folder / "i.json");
  save_inventory(folder / "i.json", loaded, {{"nothing", "no reason"}}, provenance);
  CHECK(read_file(folder / "i.json") == bytes);
}

TEST_CASE("records: writing an invalid record is a fault of ours, and writes nothing") {
  const TemporaryFolder folder;
  Provenance provenance;
  provenance.tool = "test";
  const auto code_of = [&](const Json& body) {
    try {
      save_record(folder / "r.json", "round", provenance, body);
    } catch (const Error& e) {
      return e.code();
    }
    return ExitCode::done;
  };
  CHECK(code_of({{"round", 7}, {"candidates", Json::array()}, {"omitted", Json::array()}}) == ExitCode::internal);
  CHECK(code_of({{"round", 0.0 / 0.0}}) == ExitCode::internal);
  CHECK_THROWS(read_file(folder / "r.json"));
  CHECK(code_of({{"round", 0}, {"candidates", Json::array({"posterior"})}, {"omitted", Json::array()}}) ==
        ExitCode::done);
  CHECK(load_round(folder / "r.json").ids == std::vector<std::string>{"posterior"});
}

TEST_CASE("records: candidates refuse impossible materials and unknown rows") {
  const TemporaryFolder folder;
  Candidate candidate;
  candidate.id = candidate.transform = "posterior";
  candidate.rows.push_back({"cake/plate", 0, Branch::metal, 1e7, 0.3, 1000, 6, false});
  candidate.projection.emplace_back("cake/plate", 0.85);
  candidate.timestep = {100, 50, 1e-4, 400, 1e-4, "none"};
  ScheduleOperation press;
  press.kind = ScheduleOperation::Kind::top_press;
  press.rows = {0};
  press.velocity = {0, 0, -1};
  press.end = 0.5;
  press.slab_fraction = 0.2;
  candidate.schedule.push_back(press);
  Provenance provenance;
  provenance.tool = "test";
  save_candidate(folder / "c.json", candidate, provenance);
  const Json good = load_record(folder / "c.json", "candidate");
  CHECK(load_candidate(folder / "c.json").schedule[0].velocity == Eigen::Vector3d(0, 0, -1));
  const auto error = [&](const std::function<void(Json&)>& change) {
    Json json = good;
    change(json);
    write_file(folder / "bad.json", json.dump());
    return message_of([&] { load_candidate(folder / "bad.json"); });
  };
  CHECK(contains(error([](Json& j) { j["rows"][0]["E"] = 0; }), "/rows/0/E: found 0"));
  CHECK(contains(error([](Json& j) { j["rows"][0]["nu"] = 0.5; }), "/rows/0/nu: found 0.5"));
  CHECK(contains(error([](Json& j) { j["rows"][0]["label"] = "Cheese"; }), "/rows/0/label: found \"Cheese\""));
  CHECK(contains(error([](Json& j) { j["controls"]["projection"]["cake/x"] = 0.5; }), "/controls/projection/cake/x"));
  CHECK(contains(error([](Json& j) { j["schedule"][0]["rows"][0] = 9; }), "/schedule/0"));
  CHECK(contains(error([](Json& j) { j["schedule"][0].erase("slab_fraction"); }), "slab_fraction"));
}
