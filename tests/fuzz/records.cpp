// JSON records: parsing, the schema that the document names, and the loaders that check what a schema cannot.
#include "guard.h"
#include "records/json.h"
#include "scratch.h"
#include "unit/records/record_loaders.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace physmas;
  static const Scratch scratch;
  static const bool once = [] {
    write_suite_files(scratch.folder());
    return true;
  }();
  (void)once;
  const std::string text(reinterpret_cast<const char*>(data), size);
  guard([&] {
    const Json document = parse_json(text, "input.json");
    if (!document.is_object() || !document.contains("schema") || !document.at("schema").is_string()) return;
    const std::string schema = document.at("schema").get<std::string>();
    for (const auto& [name, load] : record_loaders()) {
      if (schema != "physmas/" + name + "/1") continue;
      load(scratch.write("input.json", text));
    }
  });
  return 0;
}
