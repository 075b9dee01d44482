#include "records/overrides.h"

#include "base/error.h"
#include "records/json.h"

namespace physmas {
namespace {

// "a.b" -> "/a/b".
Json::json_pointer pointer_of(const std::string& key) {
  Json::json_pointer pointer;
  size_t begin = 0;
  while (begin <= key.size()) {
    const size_t end = std::min(key.find('.', begin), key.size());
    pointer /= key.substr(begin, end - begin);
    begin = end + 1;
  }
  return pointer;
}

Json value_of(const std::string& text) {
  try {
    return parse_json(text, "--set");
  } catch (const Error&) {
    return text;  // a bare word such as z
  }
}

}  // namespace

Json run_overrides(const std::string& file, const std::vector<std::string>& settings) {
  Json run = Json::object();
  if (!file.empty()) {
    run = load_record(file, "run");
    run.erase("schema");
    run.erase("provenance");
  }
  for (const std::string& setting : settings) {
    const size_t equals = setting.find('=');
    if (equals == 0 || equals == std::string::npos)
      throw Error(ExitCode::usage, "--set: found \"" + one_line(setting, 80) + "\", expected KEY=VALUE");
    Json patch = Json::object();
    patch[pointer_of(setting.substr(0, equals))] = value_of(setting.substr(equals + 1));
    Json document = patch;
    document["schema"] = "physmas/run/1";
    try {
      validate_record(document, "run", "--set " + one_line(setting, 80));
    } catch (const Error& e) {
      throw Error(ExitCode::usage, e.what());
    }
    run.merge_patch(patch);
  }
  return run;
}

}  // namespace physmas
