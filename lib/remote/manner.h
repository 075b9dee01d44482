// How a chat server wants to be asked: what it takes of structured output, system messages, temperature and thinking.
// Learned from its refusals, each at most once, and kept in the records of its exchanges.
#ifndef PHYSMAS_REMOTE_MANNER_H
#define PHYSMAS_REMOTE_MANNER_H

#include <optional>
#include <string>
#include <vector>

#include "remote/exchange.h"

namespace physmas::remote {

struct Manner {
  enum class Structure { json_schema, json_object, text } structure = Structure::json_schema;
  // In the question's text, too: some servers ignore `response_format` without a word, and models answer better.
  bool schema_in_text = true;
  bool given = true;  // the schema names the only values of fields that the question decides
  // A correction follows the rejected answer, so that user and assistant take turns; many chat templates want that.
  bool after_the_answer = true;
  bool system = true;  // the instructions are a system message, else the beginning of the user's
  bool temperature = true;
  enum class Thinking { as_it_is, off, unknown } thinking = Thinking::as_it_is;
  std::string length;  // what the user's max_tokens or max_completion_tokens is called, where the server wants another

  // As `manner` in schemas/exchange.json.
  Json to_json() const;
};

// Of the record that answers a request; records of earlier versions say it by their body.
Manner manner_of(const ExchangeRecord& record);

// The manner to ask in after a refusal, or nothing where asking in another one would not help: the model is not there,
// or does not see pictures, or every way was tried. Every step goes one way, so that asking ends. added: fields of the
// user's.
std::optional<Manner> manner_after(const Manner& manner, int status, const std::string& said,
                                   const std::vector<std::string>& added);

// What a server answers when it does not know a field of the request.
extern const std::vector<int> kRefusals;

}  // namespace physmas::remote

#endif
