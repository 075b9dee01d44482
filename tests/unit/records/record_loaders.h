// The loaders of the JSON records, and what the seeds in tests/fuzz/corpus/records belong to.
#ifndef PHYSMAS_TESTS_RECORD_LOADERS_H
#define PHYSMAS_TESTS_RECORD_LOADERS_H

#include <functional>
#include <map>
#include <string>

#include "base/file.h"
#include "records/cameras.h"
#include "records/candidate.h"
#include "records/configuration.h"
#include "records/evaluation.h"
#include "records/evidence.h"
#include "records/example.h"
#include "records/execution.h"
#include "records/json.h"
#include "records/material_records.h"
#include "records/metrics.h"
#include "records/plan.h"
#include "records/render.h"
#include "records/scene.h"
#include "records/screen.h"
#include "records/study.h"
#include "records/suite.h"

namespace physmas {

// The inventory of tests/data/tiny.json, which the seeds belong to.
inline Inventory tiny_inventory() {
  Inventory inventory;
  inventory.objects.emplace_back();
  inventory.objects.back().id = "lollipop";
  for (const char* part : {"candy", "stick", "residual"}) {
    inventory.rows.emplace_back();
    inventory.rows.back().object = "lollipop";
    inventory.rows.back().part = part;
    inventory.rows.back().residual = std::string(part) == "residual";
  }
  return inventory;
}

// The study that the seed of `answers` belongs to.
inline StudyKey one_case() {
  StudyKey key;
  key.token = std::string(64, 'a');
  key.methods = {"physmas", "other"};
  key.cases.emplace_back();
  key.cases.back().id = "cake";
  key.cases.back().codes = {{"c1", "physmas"}, {"c2", "other"}};
  return key;
}

// Writes what the seed of `suite` names into `folder`.
inline void write_suite_files(const std::string& folder) {
  write_file(folder + "/example.json",
             R"({"schema":"physmas/example/1","name":"lollipop","prompt":"it falls","objects":[{"id":"lollipop",)"
             R"("name":"lollipop","parts":[{"part":"candy","name":"candy","shapes":[{"type":"sphere","radius":1,)"
             R"("center":[0,0,0],"color":[1,0,0]}]}]}]})");
  write_file(folder + "/reference.json",
             R"({"schema":"physmas/configuration/1","rows":{"lollipop/candy":{"branch":"Foam",)"
             R"("E":1e6,"nu":0.3,"rho":500}},"actions":[]})");
}

inline void load_run(const std::string& path) {
  Json run = load_record(path, "run");
  run.erase("schema");
  run.erase("provenance");
  run_specification_from(run, path, "");
}

// How each record is loaded, by its name.
inline const std::map<std::string, std::function<void(const std::string& path)>>& record_loaders() {
  static const Inventory inventory = tiny_inventory();
  static const StudyKey key = one_case();
  static const std::map<std::string, std::function<void(const std::string&)>> kLoaders = {
      {"scene", [](const std::string& path) { load_scene(path, {}); }},
      {"run", load_run},
      {"inventory", [](const std::string& path) { load_inventory(path); }},
      {"plan", [](const std::string& path) { load_plan(path, inventory); }},
      {"material_records", [](const std::string& path) { load_material_records(path, inventory); }},
      {"evidence",
       [](const std::string& path) {
         load_evidence(path, {"lollipop/candy", "lollipop/stick", "lollipop/residual"});
       }},
      {"candidate", [](const std::string& path) { load_candidate(path); }},
      {"round", [](const std::string& path) { load_round(path); }},
      {"execution", [](const std::string& path) { load_execution(path); }},
      {"cameras", [](const std::string& path) { load_cameras(path); }},
      {"render", [](const std::string& path) { load_render(path); }},
      {"screen", [](const std::string& path) { load_screen(path); }},
      {"accepted", [](const std::string& path) { load_accepted(path); }},
      {"example", [](const std::string& path) { load_example(path); }},
      {"evaluation", [](const std::string& path) { load_evaluation(path); }},
      {"metrics", [](const std::string& path) { load_metrics(path); }},
      {"study", [](const std::string& path) { load_study_key(path); }},
      {"answers", [](const std::string& path) { load_study_answers(path, key); }},
      {"upr", [](const std::string& path) { load_upr(path); }},
      {"configuration", [](const std::string& path) { load_configuration(path, inventory); }},
      {"suite", [](const std::string& path) { load_suite(path); }},
  };
  return kLoaders;
}

}  // namespace physmas

#endif
