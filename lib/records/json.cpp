#include "records/json.h"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "base/file.h"
#include "records/validator.h"

namespace physmas {
namespace {

constexpr int kMaxDepth = 64;
constexpr size_t kMaxBytes = size_t{256} << 20;

// Refuses duplicate keys and deep nesting while nlohmann's parser builds the document.
class StrictCallback {
 public:
  explicit StrictCallback(const std::string& file) : file_(file) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth) {
      throw invalid_input({file_, "", "JSON nested deeper than " + std::to_string(kMaxDepth), "a shallower document"});
    }
    switch (event) {
      case Json::parse_event_t::object_start:
        keys_.emplace_back();
        break;
      case Json::parse_event_t::object_end:
        keys_.pop_back();
        break;
      case Json::parse_event_t::key:
        if (!keys_.back().insert(parsed.get<std::string>()).second) {
          throw invalid_input(
              {file_, "\"" + parsed.get<std::string>() + "\"", "the same key twice in one object", "each key once"});
        }
        break;
      default:
        break;
    }
    return true;
  }

 private:
  std::string file_;
  std::vector<std::set<std::string>> keys_;
};

void refuse_non_finite(const Json& json, const std::string& pointer) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    throw internal_error("a number that is not finite at " + pointer);
  }
  if (json.is_object()) {
    for (const auto& [key, value] : json.items()) refuse_non_finite(value, pointer + "/" + key);
  } else if (json.is_array()) {
    for (size_t i = 0; i < json.size(); ++i) refuse_non_finite(json[i], pointer + "/" + std::to_string(i));
  }
}

std::string shortened(const Json& json) {
  return one_line(compact_text(json), 80);
}

// 1-based line and column of a byte offset.
std::string line_and_column(const std::string& text, size_t byte) {
  size_t line = 1, column = 1;
  for (size_t i = 0; i + 1 < byte && i < text.size(); ++i) {
    if (text[i] == '\n') {
      ++line;
      column = 1;
    } else {
      ++column;
    }
  }
  return fmt::format("line {}, column {}", line, column);
}

}  // namespace

std::string compact_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json parse_json(const std::string& text, const std::string& file) {
  // nlohmann copies its callback, so the state lives outside.
  StrictCallback strict(file);
  try {
    return Json::parse(
        text, [&strict](int depth, Json::parse_event_t event, Json& parsed) { return strict(depth, event, parsed); });
  } catch (const Json::parse_error& e) {
    const std::string what = e.what();
    const size_t detail = what.find(": ");
    throw invalid_input({file, line_and_column(text, e.byte), "malformed JSON", "valid JSON",
                         detail == std::string::npos ? what : what.substr(detail + 2)});
  } catch (const Json::out_of_range& e) {
    throw invalid_input({file, "", "a number out of range", "finite numbers", e.what()});
  }
}

Error invalid_field(const std::string& file, const std::string& pointer, const Json& found, const std::string& expected,
                    const std::string& fix) {
  return invalid_input({file, pointer, shortened(found), expected, fix});
}

void validate_record(const Json& document, const std::string& record, const std::string& file) {
  const std::string name = "physmas/" + record + "/1";
  if (!document.is_object()) throw invalid_input({file, "", "JSON that is not an object", "the record " + name});
  if (!document.contains("schema")) throw invalid_input({file, "/schema", "nothing", "\"" + name + "\""});
  if (document["schema"] != name) throw invalid_field(file, "/schema", document["schema"], "\"" + name + "\"");
  const std::vector<SchemaViolation> violations = find_schema_violations(document, record);
  if (violations.empty()) return;
  // The deepest violation is the cause; the ones above it only say that a child is invalid. Where a value may have
  // several forms, an unknown field says more than that the other form has another type.
  const SchemaViolation* cause = &violations.front();
  for (const SchemaViolation& v : violations) {
    const bool names_a_field =
        v.description.find("unknown field") == 0 && cause->description.find("unknown field") != 0;
    if (v.depth > cause->depth || (v.depth == cause->depth && names_a_field)) cause = &v;
  }
  Json found;
  try {
    found = document.at(Json::json_pointer(cause->pointer));
  } catch (const Json::exception&) {
  }
  throw invalid_input({file, cause->pointer.empty() ? "/" : cause->pointer, shortened(found),
                       "what schemas/" + record + ".json allows", cause->description});
}

Json load_record(const std::string& path, const std::string& record) {
  Json document = parse_json(read_file(path, kMaxBytes), path);
  validate_record(document, record, path);
  return document;
}

void save_record(const std::string& path, const std::string& record, const Provenance& provenance, const Json& body) {
  Json document;
  document["schema"] = "physmas/" + record + "/1";
  document["provenance"] = to_json(provenance, folder_of(path));
  for (const auto& [key, value] : body.items()) document[key] = value;
  refuse_non_finite(document, "");
  try {
    validate_record(document, record, path);
  } catch (const Error& e) {
    throw internal_error(std::string("about to write an invalid record: ") + e.what());
  }
  write_file(path, record_text(document));
}

std::string record_text(const Json& document) {
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json to_json(const Eigen::Vector3d& v) {
  // Adding zero turns -0 into 0.
  return Json::array({v.x() + 0.0, v.y() + 0.0, v.z() + 0.0});
}

Eigen::Vector3d vector3_from(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json to_json(const Provenance& provenance, const std::string& folder) {
  Json json;
  json["tool"] = provenance.tool;
  json["version"] = PHYSMAS_VERSION;
  json["options"] = Json::object();
  for (const auto& [name, value] : provenance.options) json["options"][name] = value;
  const auto files_json = [&](const std::vector<Provenance::Input>& files) {
    Json list = Json::array();
    for (const Provenance::Input& file : files) {
      Json entry;
      entry["path"] = portable_path(file.path, folder);
      entry["sha256"] = file.sha256;
      if (file.without_runtime) entry["without"] = "runtime";
      list.push_back(entry);
    }
    return list;
  };
  json["inputs"] = files_json(provenance.inputs);
  if (!provenance.outputs.empty()) json["outputs"] = files_json(provenance.outputs);
  return json;
}

Json to_json(const std::vector<Omission>& omitted) {
  Json json = Json::array();
  for (const Omission& omission : omitted) json.push_back({{"what", omission.what}, {"why", omission.why}});
  return json;
}

Json to_json(const std::vector<ExchangeReference>& exchanges) {
  Json json = Json::array();
  for (const ExchangeReference& exchange : exchanges)
    json.push_back({{"name", exchange.name}, {"sha256", exchange.sha256}});
  return json;
}

std::vector<ExchangeReference> exchanges_from(const Json& document) {
  std::vector<ExchangeReference> exchanges;
  for (const Json& entry : document.value("exchanges", Json::array())) {
    exchanges.push_back({entry.at("name").get<std::string>(), entry.at("sha256").get<std::string>()});
  }
  return exchanges;
}

std::vector<Omission> omissions_from(const Json& document) {
  std::vector<Omission> omitted;
  for (const Json& entry : document.value("omitted", Json::array())) {
    omitted.push_back({entry.at("what").get<std::string>(), entry.at("why").get<std::string>()});
  }
  return omitted;
}

}  // namespace physmas
