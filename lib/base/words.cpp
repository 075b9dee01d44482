#include "base/words.h"

#include <cctype>
#include <utility>

namespace physmas {
namespace {

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 0x80;
}
bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}
char lower(char c) {
  return static_cast<unsigned char>(c) < 0x80 ? static_cast<char>(std::tolower(c)) : c;
}

bool ends_with(const std::string& word, const char* ending) {
  const std::string e = ending;
  return word.size() >= e.size() && word.compare(word.size() - e.size(), e.size(), e) == 0;
}

bool is_vowel(char c) {
  return c == 'a' || c == 'e' || c == 'i' || c == 'o' || c == 'u';
}

// Typographic apostrophes become the plain one.
std::string plain_apostrophes(const std::string& text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 3, "\xE2\x80\x99") == 0) {
      plain += '\'';
      i += 2;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

}  // namespace

std::vector<std::string> tokens_of(const std::string& original) {
  const std::string text = plain_apostrophes(original);
  std::vector<std::string> tokens;
  size_t i = 0;
  while (i < text.size()) {
    const char c = text[i];
    std::string token;
    if (text.compare(i, 3, "m/s") == 0 && (i + 3 == text.size() || !is_letter(text[i + 3]))) {
      token = "m/s";
      i += 3;
    } else if (is_letter(c)) {
      while (i < text.size() && is_letter(text[i])) token += lower(text[i++]);
      if (i + 1 < text.size() && text[i] == '\'' && lower(text[i + 1]) == 's' &&
          (i + 2 == text.size() || !is_letter(text[i + 2]))) {
        i += 2;
      }
    } else if (is_digit(c)) {
      while (i < text.size() && (is_digit(text[i]) || (text[i] == '.' && i + 1 < text.size() && is_digit(text[i + 1]))))
        token += text[i++];
    } else if ((c == '+' || c == '-') && i + 1 < text.size() && lower(text[i + 1]) >= 'x' &&
               lower(text[i + 1]) <= 'z' && (i + 2 == text.size() || !is_letter(text[i + 2]))) {
      token = {c, lower(text[i + 1])};
      i += 2;
    } else {
      if (c == ',' || c == '.' || c == ';' || c == ':' || c == '!' || c == '?' || c == '\n') token = ",";
      ++i;
    }
    if (!token.empty()) tokens.push_back(token);
  }
  return tokens;
}

std::vector<std::string> name_words(const std::string& name) {
  std::vector<std::string> words;
  for (const std::string& token : tokens_of(name)) {
    if (token != ",") words.push_back(singular(token));
  }
  return words;
}

std::string singular(const std::string& noun) {
  static const std::vector<std::pair<std::string, std::string>> kIrregular = {
      {"leaves", "leaf"},   {"knives", "knife"},  {"halves", "half"},   {"shelves", "shelf"},
      {"feet", "foot"},     {"teeth", "tooth"},   {"people", "person"}, {"children", "child"},
      {"mice", "mouse"},    {"geese", "goose"},   {"loaves", "loaf"},   {"wolves", "wolf"},
      {"scarves", "scarf"}, {"canvas", "canvas"}, {"gas", "gas"},       {"chassis", "chassis"}};
  for (const auto& [plural, base] : kIrregular) {
    if (noun == plural) return base;
  }
  const size_t n = noun.size();
  if (n > 4 && ends_with(noun, "ies")) return noun.substr(0, n - 3) + "y";
  for (const char* ending : {"sses", "shes", "ches", "xes", "zes", "oes"}) {
    if (n > 4 && ends_with(noun, ending)) return noun.substr(0, n - 2);
  }
  if (n > 2 && ends_with(noun, "s") && !ends_with(noun, "ss") && !ends_with(noun, "us") && !ends_with(noun, "is"))
    return noun.substr(0, n - 1);
  return noun;
}

std::vector<std::string> verb_forms(const std::string& verb) {
  const std::string stem = verb.substr(0, verb.size() - 1);
  const char last = verb.back(), before = verb.size() > 1 ? verb[verb.size() - 2] : 'a';
  if (last == 'e') return {verb, verb + "s", verb + "d", stem + "ing"};
  if (last == 'y' && !is_vowel(before)) return {verb, stem + "ies", stem + "ied", verb + "ing"};
  std::vector<std::string> forms = {verb, verb + "s", verb + "es", verb + "ed", verb + "ing"};
  if (!is_vowel(last) && is_vowel(before)) {
    forms.push_back(verb + last + "ed");
    forms.push_back(verb + last + "ing");
  }
  return forms;
}

std::string identifier_of(const std::string& text) {
  std::string id;
  for (const char c : text) {
    const char l = lower(c);
    if ((l >= 'a' && l <= 'z') || is_digit(l)) {
      id += l;
    } else if (!id.empty() && id.back() != '-') {
      id += '-';
    }
    if (id.size() == 64) break;
  }
  while (!id.empty() && id.back() == '-') id.pop_back();
  return id.empty() ? "object" : id;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

std::string join(const std::vector<std::string>& items, const std::string& separator) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : separator) + item;
  return text;
}

}  // namespace physmas
