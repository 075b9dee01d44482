// A chat model behind an OpenAI-compatible /v1/chat/completions: one question, one JSON object as the answer.
#ifndef PHYSMAS_REMOTE_CHAT_H
#define PHYSMAS_REMOTE_CHAT_H

#include <functional>
#include <string>
#include <vector>

#include "remote/backend.h"

namespace physmas::remote {

struct Question {
  std::string name;                 // [a-z0-9_-]+; its exchanges are NAME_1, NAME_2, ...
  std::string instructions;         // the system message: a prompt file
  std::string text;                 // the user message
  std::vector<std::string> images;  // PNG files, after the text
  std::string schema;               // the answer's schema, schemas/SCHEMA.json
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
  // asks: how often a question is asked until an answer is acceptable.
  ChatClient(Backend& backend, std::string model, int asks = 2);

  // Asks at temperature 0 with the schema as structured output; a server that refuses that gets the schema in the text
  // from then on. Errors have exit code 4: no answer within the schema, an answer cut off, a refusal.
  Answer ask(const Question& question);

 private:
  Json request_body(const Question& question, const std::string& correction) const;
  std::string content_of(const Reply& reply, const std::string& name) const;

  Backend& backend_;
  std::string model_;
  int asks_;
  bool structured_ = true;
};

// The JSON object in a model's text: the text itself, or what a code fence or prose surrounds, after any
// <think>...</think>. Empty when there is none.
std::string object_in(const std::string& text);

}  // namespace physmas::remote

#endif
