#include "records/json.h"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "base/file.h"
#include "records/validator.h"

namespace physmas {
namespace {

constexpr size_t kMaxDepth = 64;
constexpr size_t kMostKeys = 4096;  // of an object; looking for one of them takes time in proportion
constexpr size_t kMaxBytes = size_t{256} << 20;

std::string line_and_column(const std::string& text, size_t byte);

// Builds the document from what nlohmann's parser meets, and refuses duplicate keys, deep nesting and long objects on
// the way. Not the parser's own builder: that looks through all keys of an object for each further one.
class StrictBuilder : public nlohmann::json_sax<Json> {
 public:
  StrictBuilder(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  Json document;

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { throw internal_error("binary data in JSON text"); }

  bool start_object(std::size_t) override {
    open(add_place(Json::object()));
    keys_.emplace_back();
    return true;
  }
  bool key(string_t& key) override {
    std::set<std::string>& keys = keys_.back();
    if (!keys.insert(key).second)
      throw invalid_input({file_, "\"" + key + "\"", "the same key twice in one object", "each key once"});
    if (keys.size() > kMostKeys)
      throw invalid_input({file_, "\"" + key + "\"", fmt::format("more than {} keys in one object", kMostKeys),
                           "fewer keys, or a list"});
    key_ = std::move(key);
    return true;
  }
  bool end_object() override {
    keys_.pop_back();
    open_.pop_back();
    return true;
  }
  bool start_array(std::size_t) override {
    open(add_place(Json::array()));
    return true;
  }
  bool end_array() override {
    open_.pop_back();
    return true;
  }

  bool parse_error(std::size_t byte, const std::string& token, const Json::exception& error) override {
    const std::string where = line_and_column(text_, byte);
    const std::string what = error.what();
    if (dynamic_cast<const Json::out_of_range*>(&error) != nullptr)
      throw invalid_input({file_, where, "a number out of range, " + one_line(token, 60), "finite numbers"});
    const size_t detail = what.find(": ");
    throw invalid_input(
        {file_, where, "malformed JSON", "valid JSON", detail == std::string::npos ? what : what.substr(detail + 2)});
  }

 private:
  template <class Value>
  bool add(Value&& value) {
    add_place(Json(std::forward<Value>(value)));
    return true;
  }

  // Where the value now is. Nothing is added to what is around it while it is open, so it stays there.
  Json* add_place(Json value) {
    if (open_.empty()) {
      document = std::move(value);
      return &document;
    }
    Json& parent = *open_.back();
    if (parent.is_array()) {
      auto& items = parent.get_ref<Json::array_t&>();
      items.push_back(std::move(value));
      return &items.back();
    }
    Json::object_t::Container& fields = parent.get_ref<Json::object_t&>();
    fields.emplace_back(std::move(key_), std::move(value));
    return &fields.back().second;
  }

  void open(Json* place) {
    open_.push_back(place);
    if (open_.size() > kMaxDepth)
      throw invalid_input({file_, "", fmt::format("JSON nested deeper than {}", kMaxDepth), "a shallower document"});
  }

  const std::string& text_;
  std::string file_, key_;
  std::vector<Json*> open_;
  std::vector<std::set<std::string>> keys_;  // of each open object
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
  StrictBuilder builder(text, file);
  Json::sax_parse(text, &builder);
  return std::move(builder.document);
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
