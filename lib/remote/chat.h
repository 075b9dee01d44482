// A chat model behind an OpenAI-compatible /v1/chat/completions: one question, one JSON object as the answer.
#ifndef PHYSMAS_REMOTE_CHAT_H
#define PHYSMAS_REMOTE_CHAT_H

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "remote/backend.h"
#include "remote/manner.h"

namespace physmas::remote {

struct Question {
  std::string name;                 // [a-z0-9_-]+; its exchanges are NAME_1, NAME_2, ...
  std::string instructions;         // the system message: a prompt file
  std::string text;                 // the user message
  std::vector<std::string> images;  // PNG files, after the text
  std::string schema;               // the answer's schema, schemas/SCHEMA.json
  // What the question decides of the answer, as JSON pointers into the schema and what stands there then: a field's only
  // values, a list's length. A server that holds answers to the schema then holds them to these.
  std::vector<std::pair<std::string, Json>> given;
  // Why an answer that fits the schema is not acceptable; empty when it is. Optional.
  std::function<std::string(const Json&)> reject;
};

struct Answer {
  Json json;                          // fits the schema
  std::vector<std::string> rejected;  // why earlier answers to the question were rejected
};

class ChatClient {
 public:
  // backend: must outlive the client. model: as the server knows it; may be empty with a recorded back end only
  // (usage Error otherwise).
  // added: fields that go into every request (load_body_fields), or null. asks: how often a question is asked until an
  // answer is acceptable.
  ChatClient(Backend& backend, std::string model, Json added = Json(), int asks = 2);

  // Asks at temperature 0, with the schema in the text and as structured output, as far as the server takes it
  // (manner.h). Errors have exit code 4: no answer within the schema, an answer cut off, a refusal.
  Answer ask(const Question& question);

  // How the server was asked last.
  const Manner& manner() const { return manner_; }

 private:
  // A rejected answer, and why.
  struct Rejected {
    std::string answer, why;
  };
  Json request_body(const Question& question, const Rejected* rejected) const;

  Backend& backend_;
  std::string model_;
  Json added_;
  int asks_;
  Manner manner_;
};

// What a chat completion says.
struct Said {
  std::string answer;    // without what the model thought
  std::string thought;   // as long as the server keeps it apart, or the answer holds it: "<think>..."
  bool cut_off = false;  // the server ended it (finish_reason "length")
};
// Errors (exit code 4) name `name`: a refusal, a withheld answer, no chat completion. A server may put the whole answer
// where thoughts belong, and nothing else; it is the answer where it is one JSON object.
Said said_in(const Json& reply, const std::string& name);

// The JSON object in a model's text: the text itself, or what a code fence or prose surrounds, after any
// <think>...</think>. Empty when there is none, or the thought does not end.
std::string object_in(const std::string& text);

}  // namespace physmas::remote

#endif
