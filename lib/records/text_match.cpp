#include "records/text_match.h"

#include <algorithm>
#include <cctype>

namespace physmas {

std::string match_text(std::initializer_list<std::string> fields) {
  std::string text;
  bool first = true;
  for (const std::string& field : fields) {
    if (!first) text += ' ';
    first = false;
    text += field;
  }
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

RowText row_text(const InventoryRow& row, std::initializer_list<std::string> fields) {
  RowText result = {match_text(fields), row.named_by_prompt};
  if (!result.whole_words) return result;
  for (char& c : result.text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = ' ';
  }
  result.text = " " + result.text + " ";
  return result;
}

bool contains_any(const RowText& text, const std::vector<const char*>& tokens) {
  return std::any_of(tokens.begin(), tokens.end(), [&](const char* token) {
    const std::string sought = text.whole_words ? " " + std::string(token) + " " : token;
    return text.text.find(sought) != std::string::npos;
  });
}

std::set<std::string> words_of(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      word += c;
    } else if (!word.empty()) {
      words.insert(word);
      word.clear();
    }
  }
  if (!word.empty()) words.insert(word);
  return words;
}

}  // namespace physmas
