#include "remote/manner.h"

#include <algorithm>
#include <cctype>

#include "base/words.h"
#include "records/json.h"

namespace physmas::remote {
namespace {

using Structure = Manner::Structure;
using Thinking = Manner::Thinking;

const std::vector<std::pair<Structure, const char*>> kStructures = {
    {Structure::json_schema, "json_schema"}, {Structure::json_object, "json_object"}, {Structure::text, "text"}};
const std::vector<std::pair<Thinking, const char*>> kThinking = {
    {Thinking::as_it_is, "as it is"}, {Thinking::off, "off"}, {Thinking::unknown, "unknown"}};
constexpr const char *kAfterAnswer = "after the answer", *kAfterQuestion = "after the question";

template <class Names, class Value>
const char* name_in(const Names& names, Value value) {
  return std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.first == value; })->second;
}

template <class Names>
auto value_in(const Names& names, const std::string& name) {
  return std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.second == name; })->first;
}

}  // namespace

const std::vector<int> kRefusals = {400, 404, 415, 422, 501};

Json Manner::to_json() const {
  return {{"structure", name_in(kStructures, structure)},
          {"schema_in_text", schema_in_text},
          {"given", given},
          {"correction", after_the_answer ? kAfterAnswer : kAfterQuestion},
          {"system", system},
          {"temperature", temperature},
          {"thinking", name_in(kThinking, thinking)},
          {"length", length}};
}

Manner manner_of(const ExchangeRecord& record) {
  Manner manner;
  const Json& json = record.manner;
  if (json.is_object()) {
    manner.structure = value_in(kStructures, json.value("structure", "json_schema"));
    manner.schema_in_text = json.value("schema_in_text", true);
    manner.given = json.value("given", true);
    manner.after_the_answer = json.value("correction", kAfterAnswer) == kAfterAnswer;
    manner.system = json.value("system", true);
    manner.temperature = json.value("temperature", true);
    manner.thinking = value_in(kThinking, json.value("thinking", "as it is"));
    manner.length = json.value("length", "");
    return manner;
  }
  manner.structure = record.request_body.contains("response_format") ? Structure::json_schema : Structure::text;
  manner.schema_in_text = manner.structure == Structure::text;
  manner.given = manner.after_the_answer = false;
  return manner;
}

std::optional<Manner> manner_after(const Manner& manner, int status, const std::string& said,
                                   const std::vector<std::string>& added) {
  const std::string words = lower_case(said);
  const auto says = [&](const char* part) { return words.find(part) != std::string::npos; };
  const auto is_added = [&](const char* field) { return std::find(added.begin(), added.end(), field) != added.end(); };
  Manner next = manner;
  // A server that names the field knows best.
  if (manner.temperature && says("temperature") && !is_added("temperature")) {
    next.temperature = false;
    return next;
  }
  if (manner.length.empty() && says("max_completion_tokens") &&
      (is_added("max_tokens") || is_added("max_completion_tokens"))) {
    next.length = is_added("max_tokens") ? "max_completion_tokens" : "max_tokens";
    return next;
  }
  if (manner.length.empty() && says("max_tokens") && is_added("max_tokens") && says("unsupported")) {
    next.length = "max_completion_tokens";
    return next;
  }
  const bool of_thinking = says("enable_thinking") || says("chat_template_kwargs") || says("thinking");
  if (of_thinking && manner.thinking != Thinking::unknown && !is_added("enable_thinking") &&
      !is_added("chat_template_kwargs")) {
    next.thinking = manner.thinking == Thinking::off ? Thinking::unknown : Thinking::off;
    return next;
  }
  if (manner.system && says("system") && (says("role") || says("message"))) {
    next.system = false;
    return next;
  }
  // Neither a model that is not there nor one without eyes is helped by another way of asking.
  const bool no_model = status == 404 && says("model");
  const char* const of_images[] = {"image input",    "input image", "support image", "support for image",
                                   "images are not", "0 image",     "multimodal",    "multi-modal",
                                   "mmproj",         "vision"};
  const bool no_eyes = std::any_of(std::begin(of_images), std::end(of_images), says);
  if (no_model || no_eyes || manner.structure == Structure::text) return std::nullopt;
  next.structure = manner.structure == Structure::json_schema ? Structure::json_object : Structure::text;
  return next;
}

}  // namespace physmas::remote
