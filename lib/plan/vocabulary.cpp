#include "plan/vocabulary.h"

#include <algorithm>

#include "plan/word_table.h"

namespace physmas::plan {
namespace {

bool is_small(SmallWord kind, const std::string& word) {
  return word_table().small[static_cast<int>(kind)].count(word) > 0;
}

// The value of `word`, a zero where the table does not have it.
template <class Value>
Value value_of(const std::map<std::string, Value>& words, const std::string& word) {
  const auto found = words.find(word);
  return found == words.end() ? Value() : found->second;
}

}  // namespace

std::optional<Verb> find_verb(const std::string& token) {
  const auto found = word_table().verbs.find(token);
  if (found == word_table().verbs.end()) return std::nullopt;
  return found->second;
}

DirectionWord find_direction(const std::string& token) {
  return value_of(word_table().directions, token);
}

DirectionWord opposite(DirectionWord word) {
  switch (word) {
    case DirectionWord::up:
      return DirectionWord::down;
    case DirectionWord::down:
      return DirectionWord::up;
    case DirectionWord::left:
      return DirectionWord::right;
    case DirectionWord::right:
      return DirectionWord::left;
    case DirectionWord::toward:
      return DirectionWord::away;
    case DirectionWord::away:
      return DirectionWord::toward;
    case DirectionWord::plus_x:
      return DirectionWord::minus_x;
    case DirectionWord::minus_x:
      return DirectionWord::plus_x;
    case DirectionWord::plus_y:
      return DirectionWord::minus_y;
    case DirectionWord::minus_y:
      return DirectionWord::plus_y;
    case DirectionWord::plus_z:
      return DirectionWord::minus_z;
    case DirectionWord::minus_z:
      return DirectionWord::plus_z;
    case DirectionWord::clockwise:
      return DirectionWord::counterclockwise;
    case DirectionWord::counterclockwise:
      return DirectionWord::clockwise;
    case DirectionWord::none:
      break;
  }
  return DirectionWord::none;
}

Region find_region(const std::string& token) {
  return value_of(word_table().regions, token);
}

std::optional<int> find_material(const std::string& token) {
  const auto found = word_table().materials.find(token);
  if (found == word_table().materials.end()) return std::nullopt;
  return found->second;
}

std::vector<std::string> replace_phrases(const std::vector<std::string>& tokens) {
  std::vector<std::string> replaced;
  for (size_t i = 0; i < tokens.size();) {
    const auto fits = [&](const auto& phrase) {
      return phrase.first.size() <= tokens.size() - i &&
             std::equal(phrase.first.begin(), phrase.first.end(), tokens.begin() + static_cast<long>(i));
    };
    const auto& phrases = word_table().phrases;
    const auto found = std::find_if(phrases.begin(), phrases.end(), fits);
    replaced.push_back(found == phrases.end() ? tokens[i] : found->second);
    i += found == phrases.end() ? 1 : found->first.size();
  }
  return replaced;
}

double strength_factor(const std::string& token) {
  return value_of(word_table().strengths, token);
}

double intensifier(const std::string& token) {
  return value_of(word_table().intensifiers, token);
}

bool is_determiner(const std::string& token) {
  return is_small(SmallWord::determiner, token);
}

bool is_pronoun(const std::string& token) {
  return is_small(SmallWord::pronoun, token);
}

bool makes_passive(const std::string& token) {
  return is_small(SmallWord::passive, token);
}

bool is_auxiliary(const std::string& token) {
  return makes_passive(token) || is_small(SmallWord::auxiliary, token);
}

bool gives(const std::string& token) {
  return is_small(SmallWord::giving, token);
}

bool is_negation(const std::string& token) {
  return is_small(SmallWord::negation, token);
}

bool ends_clause(const std::string& token) {
  return is_small(SmallWord::clause_end, token);
}

bool is_wind(const std::string& noun) {
  return is_small(SmallWord::wind, noun);
}

bool is_external(const std::string& noun) {
  return is_wind(noun) || is_small(SmallWord::external, noun);
}

bool is_ground(const std::string& noun) {
  return is_small(SmallWord::ground, noun);
}

bool is_tool(const std::string& noun) {
  return is_small(SmallWord::tool, noun);
}

bool means_whole(const std::string& noun) {
  return is_small(SmallWord::whole, noun);
}

bool is_general(const std::string& noun) {
  return is_small(SmallWord::general, noun);
}

bool is_filler(const std::string& token) {
  return is_small(SmallWord::filler, token);
}

}  // namespace physmas::plan
