#include "records/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/file.h"
#include "records/json.h"

namespace physmas {
namespace {

class Loader {
 public:
  explicit Loader(const std::string& path) : path_(path), document_(load_record(path, "evaluation")) {}

  Evaluation load() {
    evaluation_.path = path_;
    for (const Json& json : document_.at("methods")) {
      evaluation_.methods.push_back({json.at("id").get<std::string>(), json.at("name").get<std::string>()});
      const std::string pointer = fmt::format("/methods/{}/id", evaluation_.methods.size() - 1);
      if (!methods_.insert(evaluation_.methods.back().id).second)
        throw invalid_field(path_, pointer, json.at("id"), "an id that no other method has");
    }
    evaluation_.comparison = method_ids("comparison");
    if (document_.contains("ablation")) evaluation_.ablation = method_ids("ablation");
    for (const Json& metric : document_.at("required")) evaluation_.required.push_back(metric.get<std::string>());
    std::set<std::string> ids;
    for (const Json& json : document_.at("cases")) {
      const std::string pointer = fmt::format("/cases/{}", evaluation_.cases.size());
      evaluation_.cases.push_back(load_case(json, pointer));
      if (!ids.insert(evaluation_.cases.back().id).second)
        throw invalid_field(path_, pointer + "/id", json.at("id"), "an id that no other case has");
    }
    return evaluation_;
  }

 private:
  std::vector<std::string> strings(const Json& json, const std::string& pointer) {
    std::vector<std::string> list;
    for (size_t i = 0; i < json.size(); ++i) {
      list.push_back(json[i].get<std::string>());
      if (std::count(list.begin(), list.end(), list.back()) > 1)
        throw invalid_field(path_, fmt::format("{}/{}", pointer, i), json[i], "each entry once");
    }
    return list;
  }

  std::vector<std::string> method_ids(const std::string& field) {
    std::vector<std::string> ids = strings(document_.at(field), "/" + field);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (methods_.count(ids[i]) == 0)
        throw invalid_field(path_, fmt::format("/{}/{}", field, i), Json(ids[i]), "the id of a method");
    }
    return ids;
  }

  EvaluationResult load_result(const Json& json, const std::string& pointer) {
    const std::string folder = folder_of(path_);
    EvaluationResult result;
    result.done = json.at("status") == "done";
    result.reason = json.value("reason", "");
    result.seconds = json.value("seconds", 0.0);
    if (json.contains("video"))
      result.video = resolve_inside(folder, json.at("video").get<std::string>(), path_, pointer + "/video");
    if (json.contains("metrics")) {
      for (const std::string& file : strings(json.at("metrics"), pointer + "/metrics"))
        result.metrics.push_back(resolve_inside(folder, file, path_, pointer + "/metrics"));
    }
    return result;
  }

  EvaluationCase load_case(const Json& json, const std::string& pointer) {
    EvaluationCase c;
    c.id = json.at("id").get<std::string>();
    c.multi_object = json.at("kind") == "multi-object";
    c.prompt = json.at("prompt").get<std::string>();
    if (json.contains("profiles")) c.profiles = strings(json.at("profiles"), pointer + "/profiles");
    if (json.contains("objects")) c.objects = strings(json.at("objects"), pointer + "/objects");
    if (c.profiles.empty() != c.multi_object)
      throw invalid_input({path_, pointer + "/profiles", c.profiles.empty() ? "none" : "some",
                           c.multi_object ? "none in a multi-object case" : "the profiles of a multi-part case"});
    if (c.objects.empty() == c.multi_object)
      throw invalid_input(
          {path_, pointer + "/objects", c.objects.empty() ? "none" : "some",
           c.multi_object ? "the registered objects of a multi-object case" : "none in a multi-part case"});
    for (const auto& [method, result] : json.at("results").items()) {
      if (methods_.count(method) == 0)
        throw invalid_field(path_, pointer + "/results", Json(method), "the id of a method");
      c.results[method] = load_result(result, pointer + "/results/" + method);
    }
    for (const auto& table : {evaluation_.comparison, evaluation_.ablation}) {
      for (const std::string& method : table) {
        if (c.results.count(method) == 0) c.results[method].reason = "no result";
      }
    }
    return c;
  }

  std::string path_;
  Json document_;
  Evaluation evaluation_;
  std::set<std::string> methods_;
};

}  // namespace

const std::string& Evaluation::method_name(const std::string& id) const {
  return std::find_if(methods.begin(), methods.end(), [&](const EvaluationMethod& m) { return m.id == id; })->name;
}

Evaluation load_evaluation(const std::string& path) {
  return Loader(path).load();
}

}  // namespace physmas
