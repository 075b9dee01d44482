#include "records/script_json.h"

#include "records/json.h"

namespace physmas {

std::string script_json(const Json& json) {
  std::string text;
  for (const char c : compact_text(json)) text += c == '<' ? "\\u003c" : std::string(1, c);
  return text;
}

}  // namespace physmas
