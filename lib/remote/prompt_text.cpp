#include "remote/prompt_text.h"

#include "base/error.h"

namespace physmas::remote {

std::string prompt_text(const std::string& name) {
  for (int i = 0; i < kPromptTextCount; ++i) {
    if (name == kPromptTexts[i].name) return kPromptTexts[i].text;
  }
  throw internal_error("no prompt named " + name);
}

}  // namespace physmas::remote
