#include "remote/chat.h"

#include <fmt/format.h>

#include "records/json.h"
#include "records/validator.h"

namespace physmas::remote {
namespace {

constexpr size_t kLongestQuote = 4000;  // bytes of a rejected answer that a correction repeats
const std::string kThought = "<think>", kEndOfThought = "</think>";

std::string trimmed(const std::string& text) {
  const char* const blanks = " \t\r\n";
  const size_t from = text.find_first_not_of(blanks);
  return from == std::string::npos ? "" : text.substr(from, text.find_last_not_of(blanks) - from + 1);
}

// At most kLongestQuote bytes, and no half character.
std::string beginning_of(const std::string& text) {
  if (text.size() <= kLongestQuote) return text;
  size_t end = kLongestQuote;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end);
}

// A message's content: a text, or a list of parts, of which those that are no text (thoughts, pictures) do not count.
std::string text_of(const Json& content) {
  if (content.is_string()) return content.get<std::string>();
  std::string text;
  if (!content.is_array()) return text;
  for (const Json& part : content) {
    if (part.is_string()) text += part.get<std::string>();
    if (!part.is_object()) continue;
    const Json type = part.value("type", Json("text")), words = part.value("text", Json());
    if ((type == "text" || type == "output_text") && words.is_string()) text += words.get<std::string>();
  }
  return text;
}

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
  const size_t thought = text.rfind(kEndOfThought);
  if (thought == std::string::npos && trimmed(text).rfind(kThought, 0) == 0) return "";
  const size_t from = text.find('{', thought == std::string::npos ? 0 : thought + kEndOfThought.size());
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

Said said_in(const Json& reply, const std::string& name) {
  const Json none;
  const auto at = [&](const char* pointer) {
    const Json::json_pointer p(pointer);
    return reply.contains(p) ? reply.at(p) : none;
  };
  const Json message = at("/choices/0/message"), reason = at("/choices/0/finish_reason"),
             refusal = at("/choices/0/message/refusal");
  if (!message.is_object() || !reply.at("choices").is_array()) {
    // Some servers report an error with status 200.
    const std::string words = reply.is_object() && reply.contains("error") ? words_of(reply.dump()) : "";
    throw provider_error(name, words.empty()
                                   ? "found a reply without /choices/0/message/content, expected a chat completion: " +
                                         one_line(reply.dump(), 120)
                                   : "the server answers with an error: " + words);
  }
  if (refusal.is_string() && !refusal.get<std::string>().empty())
    throw provider_error(name, "the model refused to answer: " + one_line(refusal.get<std::string>(), 200));
  if (reason == "content_filter") throw provider_error(name, "the server's content filter withheld the answer");
  Said said;
  said.cut_off = reason == "length";
  said.answer = text_of(message.value("content", none));
  for (const char* field : {"reasoning_content", "reasoning", "thinking"}) {
    if (said.thought.empty()) said.thought = text_of(message.value(field, none));
  }
  if (!trimmed(said.answer).empty()) return said;
  const std::string whole = trimmed(said.thought);
  if (!whole.empty() && object_in(whole) == whole) std::swap(said.answer, said.thought);
  return said;
}

ChatClient::ChatClient(Backend& backend, std::string model, Json added, int asks)
    : backend_(backend), model_(std::move(model)), added_(std::move(added)), asks_(asks) {
  if (model_.empty() && !backend_.is_recorded())
    throw Error(ExitCode::usage, "--model is required with a remote --agent: the model's name on that server");
}

Json ChatClient::request_body(const Question& question, const Rejected* rejected) const {
  Json schema = schema_document(question.schema);
  schema.erase("$schema");
  if (manner_.given) {
    for (const auto& [pointer, value] : question.given) schema[Json::json_pointer(pointer)] = value;
  }
  std::string text = question.text;
  if (manner_.schema_in_text)
    text += "\n\nReply with one JSON object and nothing else. It must fit this JSON Schema:\n" + schema.dump();
  if (!manner_.system) text = question.instructions + "\n\n" + text;
  Json content = Json::array();
  content.push_back({{"type", "text"}, {"text", text}});
  for (size_t i = 0; i < question.images.size(); ++i)
    content.push_back({{"type", "image_url"}, {"image_url", {{"url", ""}}}});
  Json messages = Json::array();
  if (manner_.system) messages.push_back({{"role", "system"}, {"content", question.instructions}});
  messages.push_back({{"role", "user"}, {"content", content}});
  if (rejected != nullptr) {
    // Templates that let the two take turns want a text here.
    const std::string answer = trimmed(rejected->answer).empty() ? "(no answer)" : rejected->answer;
    if (manner_.after_the_answer) messages.push_back({{"role", "assistant"}, {"content", answer}});
    messages.push_back(
        {{"role", "user"},
         {"content", "Your last answer was rejected: " + rejected->why + ". Answer the question again."}});
  }
  Json body;
  body["model"] = model_.empty() ? Json() : Json(model_);
  if (manner_.temperature) body["temperature"] = 0;
  body["messages"] = messages;
  if (manner_.structure == Manner::Structure::json_schema) {
    body["response_format"] = {{"type", "json_schema"},
                               {"json_schema", {{"name", question.schema}, {"strict", true}, {"schema", schema}}}};
  } else if (manner_.structure == Manner::Structure::json_object) {
    body["response_format"] = {{"type", "json_object"}};
  }
  if (manner_.thinking == Manner::Thinking::off) {
    // As Qwen's own service calls it, and as servers of chat templates do.
    body["enable_thinking"] = false;
    body["chat_template_kwargs"] = {{"enable_thinking", false}};
  }
  if (added_.is_object()) body.merge_patch(added_);
  if (!manner_.length.empty()) {
    const char* const other = manner_.length == "max_tokens" ? "max_completion_tokens" : "max_tokens";
    if (body.contains(other)) {
      body[manner_.length] = body[other];
      body.erase(other);
    }
  }
  return body;
}

Answer ChatClient::ask(const Question& question) {
  Answer answer;
  std::optional<Rejected> rejected;
  int sent = 0;
  for (int ask = 0; ask < asks_;) {
    Request request;
    request.name = fmt::format("{}_{}", question.name, ++sent);
    request.method = "POST";
    request.path = "/chat/completions";
    if (const auto record = backend_.recorded(request.name)) manner_ = manner_of(*record);
    request.manner = manner_.to_json();
    request.body = request_body(question, rejected ? &*rejected : nullptr);
    if (added_.is_object()) {
      for (const auto& [field, value] : added_.items()) request.added.push_back(field);
      if (!manner_.length.empty()) request.added.push_back(manner_.length);
    }
    for (size_t i = 0; i < question.images.size(); ++i) {
      request.attachments.push_back(
          {fmt::format("/messages/{}/content/{}/image_url/url", manner_.system ? 1 : 0, i + 1),
           "data:image/png;base64,", question.images[i], "png"});
    }
    request.returned_statuses = kRefusals;
    const Reply reply = backend_.exchange(request);
    if (reply.body.is_null() && reply.status >= 300) {
      const auto next = manner_after(manner_, reply.status, reply.said, request.added);
      // What a record goes on with was asked then.
      if (!next && !backend_.recorded(fmt::format("{}_{}", question.name, sent + 1)))
        throw provider_error(request.name, fmt::format("HTTP {}: {}", reply.status, words_of(reply.said)));
      if (next) manner_ = *next;
      continue;
    }
    const Said said = said_in(reply.body, request.name);
    const std::string object = object_in(said.answer);
    // A model that thinks for too long has no room left for the answer.
    const bool only_thought =
        object.empty() && (!said.thought.empty() || said.answer.find(kThought) != std::string::npos);
    if (only_thought && manner_.thinking == Manner::Thinking::as_it_is) {
      manner_.thinking = Manner::Thinking::off;
      continue;
    }
    if (said.cut_off && object.empty()) {
      throw provider_error(
          request.name, "the answer was cut off (finish_reason \"length\"); --body with max_tokens gives it more room");
    }
    ++ask;
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
    rejected = Rejected{beginning_of(said.answer), why};
  }
  throw provider_error(question.name,
                       fmt::format("no acceptable answer in {} asks; the last one: {}", asks_, answer.rejected.back()));
}

}  // namespace physmas::remote
