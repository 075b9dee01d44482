// The prompts of the agents, lib/MODULE/prompts/NAME.txt, embedded by the build.
#ifndef PHYSMAS_REMOTE_PROMPT_TEXT_H
#define PHYSMAS_REMOTE_PROMPT_TEXT_H

#include <string>

namespace physmas::remote {

struct PromptText {
  const char* name;  // "MODULE/NAME"
  const char* text;
};
extern const PromptText kPromptTexts[];
extern const int kPromptTextCount;

// The prompt "MODULE/NAME". Throws an internal Error when there is none.
std::string prompt_text(const std::string& name);

}  // namespace physmas::remote

#endif
