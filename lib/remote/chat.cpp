#include "remote/chat.h"

#include <fmt/format.h>

#include "records/json.h"
#include "records/validator.h"

namespace physmas::remote {
namespace {

// What servers answer when they do not know `response_format`.
const std::vector<int> kNoStructuredOutput = {400, 404, 415, 422, 501};

// "/labels/0/probability: found 3, expected ..." without the file part of our own records' messages.
std::string violation_of(const Json& answer, const std::string& schema) {
  const std::vector<SchemaViolation> violations = find_schema_violations(answer, schema);
  if (violations.empty()) return "";
  const SchemaViolation* deepest = &violations.front();
  for (const SchemaViolation& v : violations) {
    if (v.depth > deepest->depth) deepest = &v;
  }
  return fmt::format("{}: {}", deepest->pointer.empty() ? "/" : deepest->pointer, one_line(deepest->description, 300));
}

}  // namespace

std::string object_in(const std::string& text) {
  const std::string end_of_thought = "</think>";
  const size_t thought = text.rfind(end_of_thought);
  const size_t from = text.find('{', thought == std::string::npos ? 0 : thought + end_of_thought.size());
  if (from == std::string::npos) return "";
  // The brace that closes the first one; braces inside strings do not count.
  int depth = 0;
  bool quoted = false;
  for (size_t i = from; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{') {
      ++depth;
    } else if (c == '}' && --depth == 0) {
      return text.substr(from, i - from + 1);
    }
  }
  return "";
}

ChatClient::ChatClient(Backend& backend, std::string model, int asks)
    : backend_(backend), model_(std::move(model)), asks_(asks) {
  if (model_.empty() && !backend_.is_recorded())
    throw Error(ExitCode::usage, "--model is required with a remote --agent: the model's name on that server");
}

Json ChatClient::request_body(const Question& question, const std::string& correction) const {
  Json schema = schema_document(question.schema);
  schema.erase("$schema");
  std::string text = question.text;
  if (!structured_)
    text += "\n\nReply with one JSON object and nothing else. It must fit this JSON Schema:\n" + schema.dump();
  Json content = Json::array();
  content.push_back({{"type", "text"}, {"text", text}});
  for (size_t i = 0; i < question.images.size(); ++i)
    content.push_back({{"type", "image_url"}, {"image_url", {{"url", ""}}}});
  Json messages = Json::array();
  messages.push_back({{"role", "system"}, {"content", question.instructions}});
  messages.push_back({{"role", "user"}, {"content", content}});
  if (!correction.empty()) {
    messages.push_back({{"role", "user"},
                        {"content", "Your last answer was rejected: " + correction + ". Answer the question again."}});
  }
  Json body;
  body["model"] = model_.empty() ? Json() : Json(model_);
  body["temperature"] = 0;
  body["messages"] = messages;
  if (structured_) {
    body["response_format"] = {{"type", "json_schema"},
                               {"json_schema", {{"name", question.schema}, {"strict", true}, {"schema", schema}}}};
  }
  return body;
}

std::string ChatClient::content_of(const Reply& reply, const std::string& name) const {
  const Json none;
  const auto at = [&](const char* pointer) {
    const Json::json_pointer p(pointer);
    return reply.body.contains(p) ? reply.body.at(p) : none;
  };
  const Json content = at("/choices/0/message/content"), reason = at("/choices/0/finish_reason"),
             refusal = at("/choices/0/message/refusal");
  if (refusal.is_string() && !refusal.get<std::string>().empty())
    throw provider_error(name, "the model refused to answer: " + one_line(refusal.get<std::string>(), 200));
  if (reason == "length") throw provider_error(name, "the answer was cut off (finish_reason \"length\")");
  if (reason == "content_filter") throw provider_error(name, "the server's content filter withheld the answer");
  if (!content.is_string()) {
    throw provider_error(name, "found a reply without /choices/0/message/content, expected a chat completion: " +
                                   one_line(reply.body.dump(), 120));
  }
  return content.get<std::string>();
}

Answer ChatClient::ask(const Question& question) {
  Answer answer;
  int sent = 0;
  for (int ask = 0; ask < asks_;) {
    Request request;
    request.name = fmt::format("{}_{}", question.name, ++sent);
    request.method = "POST";
    request.path = "/chat/completions";
    request.body = request_body(question, answer.rejected.empty() ? "" : answer.rejected.back());
    for (size_t i = 0; i < question.images.size(); ++i) {
      request.attachments.push_back({fmt::format("/messages/1/content/{}/image_url/url", i + 1),
                                     "data:image/png;base64,", question.images[i], "png"});
    }
    if (structured_) request.returned_statuses = kNoStructuredOutput;
    const Reply reply = backend_.exchange(request);
    if (reply.body.is_null() && reply.status >= 300) {
      structured_ = false;
      continue;
    }
    ++ask;
    const std::string object = object_in(content_of(reply, request.name));
    std::string why;
    if (object.empty()) {
      why = "it holds no JSON object";
    } else {
      try {
        answer.json = parse_json(object, "answer");
        why = violation_of(answer.json, question.schema);
        if (why.empty() && question.reject) why = question.reject(answer.json);
      } catch (const Error& e) {
        why = e.what();
      }
    }
    if (why.empty()) return answer;
    answer.rejected.push_back(why);
  }
  throw provider_error(question.name,
                       fmt::format("no acceptable answer in {} asks; the last one: {}", asks_, answer.rejected.back()));
}

}  // namespace physmas::remote
