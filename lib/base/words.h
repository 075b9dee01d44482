// Plain English at the level that prompts need: tokens, plural and verb forms, identifiers.
#ifndef PHYSMAS_BASE_WORDS_H
#define PHYSMAS_BASE_WORDS_H

#include <string>
#include <vector>

namespace physmas {

// Lower-case tokens: words, numbers ("0.5"), signed axes ("+x"), "m/s", and the separators , . ; : as tokens of their
// own. A possessive "'s" is dropped ("the hammer's head" gives hammer head); bytes outside ASCII count as letters.
std::vector<std::string> tokens_of(const std::string& text);

// The words of a name or an identifier, each in the singular: "Left_leaves" gives left leaf.
std::vector<std::string> name_words(const std::string& name);

// A noun without its plural ending: "strawberries" -> "strawberry", "glass" -> "glass".
std::string singular(const std::string& noun);

// The regular inflections of a verb, itself included: "drop" -> drop drops dropped dropping ...
std::vector<std::string> verb_forms(const std::string& verb);

// An identifier of [a-z0-9-]+, at most 64 characters, "object" where nothing remains.
std::string identifier_of(const std::string& text);

// The letters of ASCII in lower case; others as they are.
std::string lower_case(std::string text);

// Items joined as "a, b, c".
std::string join(const std::vector<std::string>& items, const std::string& separator = ", ");

}  // namespace physmas

#endif
