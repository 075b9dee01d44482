// How names, roles and physics groups are searched for tokens (readings, "Text matching").
#ifndef PHYSMAS_RECORDS_TEXT_MATCH_H
#define PHYSMAS_RECORDS_TEXT_MATCH_H

#include <initializer_list>
#include <set>
#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas {

// The fields joined by one space in the given order (an empty field leaves its separator), lower case, underscores as
// spaces.
std::string match_text(std::initializer_list<std::string> fields);

// Fields of a row as match_text() joins them. Names of an inventory are searched for literal substrings, as the paper
// does; words of a prompt that named a row count whole only: a hedge has no edge.
struct RowText {
  std::string text;
  bool whole_words = false;
};
RowText row_text(const InventoryRow& row, std::initializer_list<std::string> fields);

// Whether `text` holds one of `tokens` (lower case).
bool contains_any(const RowText& text, const std::vector<const char*>& tokens);

// The whole words of `text`, split where a character is not alphanumeric.
std::set<std::string> words_of(const std::string& text);

}  // namespace physmas

#endif
