// Every record, field by field: what its loader refuses, and under which name. The documents are the seeds of the fuzz
// target `records`, which tools have written.
#include <doctest/doctest.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "records/json.h"
#include "unit/input_error.h"
#include "unit/records/record_loaders.h"
#include "unit/skip_test.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

// A schema says a screen's documents; no seed has them, as the tiny scene's run ends before.
const char* const kScreen = R"({"schema": "physmas/screen/1", "round": 1, "tau": 0.7, "weights": [1, 0.5],
  "candidates": [{"id": "a", "transform": "posterior", "order": 0, "round": 0,
    "features": {"video": 0.5, "part_confidence": 0.5, "diversity": 0.5, "role": 1, "base": 0.5, "density": 0.25, "solver": 1},
    "video_terms": [{"term": "motion", "value": 0.5}], "penalty": 0, "score": 0.75,
    "achieved": 0.5, "stillness": 0.75,
    "gates": [{"name": "plan", "passed": true, "measured": 1, "limit": null}],
    "valid": true, "admitted": true, "rank": 1}],
  "decision": "accept", "reason": "best", "accepted": "a", "repair": null,
  "audit": {"passed": true, "checks": [{"name": "frames", "passed": true, "measured": 50, "expected": 50}]},
  "omitted": [{"what": "b", "why": "c"}]})";
const char* const kAccepted = R"({"schema": "physmas/accepted/1", "candidate": "a", "round": 0, "score": 0.75,
  "video": "final.mp4", "frames": 50, "audit": {"plan": "plan.json"}})";
const char* const kPlan = R"({"schema": "physmas/plan/1", "prompt": "the stick hits the candy", "resolved": true,
  "actions": [{"type": "drag_pair", "source": "lollipop/stick", "target": "lollipop", "direction": [1, 0, 0],
    "magnitude": 0.5, "start": 0.25, "end": 1, "role": "target", "impact": true, "region": "slab", "follow": "target"}],
  "proposal": {"agent": "builtin"}, "corrections": ["a change"], "omitted": [{"what": "b", "why": "c"}]})";

// A place in a document: as a pointer, as messages name it, and with "#" for each index.
struct Place {
  Json::json_pointer pointer;
  std::string name, pattern;
};

// Calls `visit` for each value of `json` below the root.
void for_each_value(const Json& json, const Place& place, const std::function<void(const Place&)>& visit) {
  if (json.is_array()) {
    for (size_t i = 0; i < json.size(); ++i) {
      const Place inner = {place.pointer / i, place.name + "/" + std::to_string(i), place.pattern + "/#"};
      visit(inner);
      for_each_value(json[i], inner, visit);
    }
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      const Place inner = {place.pointer / key, place.name + "/" + key, place.pattern + "/" + key};
      visit(inner);
      for_each_value(value, inner, visit);
    }
  }
}

}  // namespace

TEST_CASE("records: what is missing or of another type is refused by its name, in every record") {
  std::map<std::string, std::string> texts = {{"screen", kScreen}, {"accepted", kAccepted}, {"plan", kPlan}};
  const std::string seeds = "tests/fuzz/corpus/records/";
  if (!std::filesystem::exists(seeds)) {
    skip_test("no " + seeds);
    return;
  }
  const TemporaryFolder folder;
  write_suite_files(folder.path());
  std::set<std::string> found;
  for (const auto& entry : record_loaders()) {
    const std::string& record = entry.first;
    CAPTURE(record);
    if (texts.count(record) == 0) texts[record] = read_file(seeds + record);
    const Json good = parse_json(texts[record], record);
    const std::string path = folder / "r.json";
    const auto refusal = [&](const Json& document) {
      write_file(path, document.dump());
      return message_of([&] { entry.second(path); });
    };
    CHECK(refusal(good) == "no error");
    for_each_value(good, Place(), [&](const Place& place) {
      CAPTURE(place.name);
      const Json::json_pointer parent = place.pointer.parent_pointer();
      if (good.at(parent).is_object()) {
        Json lacking = good;
        lacking.at(parent).erase(place.pointer.back());
        if (const std::string message = refusal(lacking); message == "no error") {
          found.insert(record + " optional " + place.pattern);
        } else {
          CHECK(message.find(path + ": /") == 0);
        }
      }
      Json wrong = good;
      wrong.at(place.pointer) = {{"a field", {"that", "nobody", "knows"}}};
      if (const std::string message = refusal(wrong); message == "no error") {
        found.insert(record + " anything " + place.pattern);
      } else {
        const std::string above = place.name.substr(0, place.name.size() - place.pointer.back().size() - 1);
        CHECK(message.find(path + ": " + above) == 0);
      }
    });
  }
  std::istringstream lines(read_file("tests/unit/records/free_fields.txt"));
  std::set<std::string> expected;
  for (std::string line; std::getline(lines, line);) {
    if (line[0] != '#') expected.insert(line);
  }
  for (const std::string& place : found) CHECK_MESSAGE(expected.count(place) == 1, "new: ", place);
  for (const std::string& place : expected) CHECK_MESSAGE(found.count(place) == 1, "not found: ", place);
}
