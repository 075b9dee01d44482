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

bool contains_any(const std::string& text, const std::vector<const char*>& tokens) {
  return std::any_of(tokens.begin(), tokens.end(),
                     [&](const char* token) { return text.find(token) != std::string::npos; });
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
