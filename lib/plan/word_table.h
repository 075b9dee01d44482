// The table of words that vocabulary.h answers from: lib/plan/words/vocabulary.txt.
#ifndef PHYSMAS_PLAN_WORD_TABLE_H
#define PHYSMAS_PLAN_WORD_TABLE_H

#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "plan/vocabulary.h"

namespace physmas::plan {

enum class SmallWord {
  determiner,
  pronoun,
  passive,
  auxiliary,
  giving,
  negation,
  clause_end,
  wind,
  external,
  tool,
  whole,
  general,
  ground,
  filler
};
constexpr int kSmallWordCount = 14;

struct WordTable {
  std::map<std::string, Verb> verbs;  // by every form
  std::map<std::string, DirectionWord> directions;
  std::map<std::string, double> strengths, intensifiers;
  std::map<std::string, Region> regions;
  std::map<std::string, int> materials;  // indices into kLabels
  std::vector<std::pair<std::vector<std::string>, std::string>>
      phrases;  // several words, and the one that they are read as
  std::array<std::set<std::string>, kSmallWordCount> small;
};

// text: as the comments of lib/plan/words/vocabulary.txt describe it. A line that does not fit them is an internal
// Error that names the line: the file is a part of the program.
WordTable parse_word_table(const std::string& text);

// The table of the program, read once.
const WordTable& word_table();

}  // namespace physmas::plan

#endif
