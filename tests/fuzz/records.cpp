// JSON records: parsing, the schema that the document names, and the loaders that check what a schema cannot.
#include <unistd.h>

#include <fstream>

#include "guard.h"
#include "records/inventory.h"
#include "records/json.h"
#include "scene/scene.h"

namespace {

// Loaders read files. One per process, removed at its end.
struct File {
  std::string path = "/tmp/physmas-fuzz-" + std::to_string(getpid()) + ".json";
  ~File() { unlink(path.c_str()); }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  static const File file;
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string record;
  guard([&] {
    const Json document = parse_json(text, "input.json");
    if (!document.is_object() || !document.contains("schema") || !document.at("schema").is_string()) return;
    const std::string schema = document.at("schema").get<std::string>();
    for (const char* name : {"scene", "inventory", "run", "plan", "evidence", "candidate", "material_records", "example",
                             "screen", "round", "render", "execution", "metrics", "exchange"}) {
      if (schema == std::string("physmas/") + name + "/1") record = name;
    }
    if (!record.empty()) validate_record(document, record, "input.json");
    std::ofstream(file.path, std::ios::binary) << text;
  });
  if (record == "scene") guard([&] { load_scene(file.path, {}); });
  if (record == "inventory") guard([&] { load_inventory(file.path); });
  if (record == "run") {
    guard([&] {
      Json run = load_record(file.path, "run");
      run.erase("schema");
      run_specification_from(run, "input.json", "");
    });
  }
  return 0;
}
