// How names, roles and physics groups are searched for tokens (readings, "Text matching").
#ifndef PHYSMAS_RECORDS_TEXT_MATCH_H
#define PHYSMAS_RECORDS_TEXT_MATCH_H

#include <initializer_list>
#include <set>
#include <string>
#include <vector>

namespace physmas {

// The fields joined by one space in the given order (an empty field leaves its separator), lower case, underscores as
// spaces.
std::string match_text(std::initializer_list<std::string> fields);

// Whether one of `tokens` (lower case) is a literal substring of `text`, which match_text() made.
bool contains_any(const std::string& text, const std::vector<const char*>& tokens);

// The whole words of `text`, split where a character is not alphanumeric.
std::set<std::string> words_of(const std::string& text);

}  // namespace physmas

#endif
