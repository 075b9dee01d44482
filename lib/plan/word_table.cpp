#include "plan/word_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "base/embedded_text.h"
#include "base/error.h"
#include "base/words.h"
#include "records/labels.h"

namespace physmas::plan {
namespace {

constexpr const char* kFile = "lib/plan/words/vocabulary.txt";

// In the order of DirectionWord, from the one after `none`.
constexpr std::array<const char*, 14> kDirections = {
    "up", "down", "left", "right", "toward", "away",      "+x",
    "-x", "+y",   "-y",   "+z",    "-z",     "clockwise", "counterclockwise"};
constexpr std::array<const char*, kSmallWordCount> kSmallWords = {
    "determiner", "pronoun",  "passive", "auxiliary", "giving",  "negation", "clause-end",
    "wind",       "external", "tool",    "whole",     "general", "ground",   "filler"};

constexpr std::array<const char*, 3> kRegions = {"top", "bottom", "side"};  // of Region, from the one after `none`
constexpr std::array<const char*, 4> kNotModelled = {"fracture", "liquid", "heat", "life"};

class Parser {
 public:
  WordTable parse(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      std::istringstream words(line);
      std::vector<std::string> entry;
      for (std::string word; words >> word;) entry.push_back(word);
      if (entry.empty() || entry[0] == "#") continue;
      if (entry[0][0] == '[') {
        section_ = line;
      } else {
        add(entry);
      }
    }
    section_ = "the table";
    if (table_.verbs.empty() || table_.directions.empty() || table_.strengths.empty() || table_.intensifiers.empty() ||
        table_.regions.empty() || table_.materials.empty() || table_.phrases.empty() ||
        std::any_of(table_.small.begin(), table_.small.end(), [](const auto& words) { return words.empty(); }))
      fail("lacks a section or a kind of small word");
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw internal_error(fmt::format("{}: line {}: {} {}", kFile, line_, section_, problem));
  }

  void add(const std::vector<std::string>& entry) {
    const size_t names = section_ == "[verbs]" ? 2 : 1;
    if (entry.size() <= names) fail("has an entry without words");
    const std::vector<std::string> words(entry.begin() + static_cast<long>(names), entry.end());
    if (section_ == "[verbs]") {
      for (const std::string& word : words) add_verb(word, meaning_of(entry[0]), direction_of(entry[1]));
    } else if (section_ == "[directions]") {
      const int direction = 1 + index_in(kDirections, entry[0]);
      for (const std::string& word : words) add_once(table_.directions, word, static_cast<DirectionWord>(direction));
    } else if (section_ == "[strengths]") {
      for (const std::string& word : words) add_once(table_.strengths, word, factor_of(entry[0]));
    } else if (section_ == "[intensifiers]") {
      for (const std::string& word : words) add_once(table_.intensifiers, word, factor_of(entry[0]));
    } else if (section_ == "[regions]") {
      const int region = 1 + static_cast<int>(index_in(kRegions, entry[0]));
      for (const std::string& word : words) add_once(table_.regions, word, static_cast<Region>(region));
    } else if (section_ == "[materials]") {
      const std::optional<int> label = find_label(entry[0]);
      if (!label) fail("does not know \"" + entry[0] + "\"");
      for (const std::string& word : words) add_once(table_.materials, word, *label);
    } else if (section_ == "[phrases]") {
      table_.phrases.emplace_back(words, entry[0]);
    } else if (section_ == "[small words]") {
      std::set<std::string>& kind = table_.small[index_in(kSmallWords, entry[0])];
      for (const std::string& word : words) {
        if (!kind.insert(word).second) fail("has \"" + word + "\" twice");
      }
    } else {
      fail("is no section that is known");
    }
  }

  // entry: the base form, then irregular forms, between colons.
  void add_verb(const std::string& entry, const Meaning& meaning, const std::string& direction) {
    std::vector<std::string> forms;
    std::istringstream parts(entry);
    for (std::string form; std::getline(parts, form, ':');) forms.push_back(form);
    const Verb verb = {forms[0], meaning, direction};
    if (std::find(forms.begin(), forms.end(), "") != forms.end() || entry.back() == ':')
      fail("has an empty form in \"" + entry + "\"");
    const std::vector<std::string> regular = verb_forms(verb.lemma);
    forms.insert(forms.end(), regular.begin(), regular.end());
    for (const std::string& form : forms) {
      const auto [there, added] = table_.verbs.emplace(form, verb);
      if (!added && there->second.lemma != verb.lemma)
        fail(fmt::format("has \"{}\" of {} and of {}", form, there->second.lemma, verb.lemma));
    }
    if (!lemmas_.insert(verb.lemma).second) fail("has \"" + verb.lemma + "\" twice");
  }

  Meaning meaning_of(const std::string& name) const {
    if (name == "gravity") return {Meaning::Kind::gravity, {}, false, ""};
    if (name == "outcome") return {Meaning::Kind::outcome, {}, false, ""};
    if (name == "tip") return {Meaning::Kind::action, ActionType::torque, true, ""};
    if (std::find(kNotModelled.begin(), kNotModelled.end(), name) != kNotModelled.end())
      return {Meaning::Kind::not_modelled, {}, false, name};
    return {Meaning::Kind::action, action_of(name), false, ""};
  }

  ActionType action_of(const std::string& name) const {
    for (const ActionLine& action : kActions) {
      if (name == action.name) return action.kind;
    }
    fail("does not know \"" + name + "\"");
  }

  std::string direction_of(const std::string& name) const {
    if (name == "-") return "";
    if (name != "up" && name != "down" && name != "in") fail("has the direction \"" + name + "\"");
    return name;
  }

  double factor_of(const std::string& text) const {
    char* end = nullptr;
    const double factor = std::strtod(text.c_str(), &end);
    if (*end != '\0' || !(factor > 0 && factor < 100)) fail("has the factor \"" + text + "\"");
    return factor;
  }

  template <class Names>
  size_t index_in(const Names& names, const std::string& name) const {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) fail("does not know \"" + name + "\"");
    return static_cast<size_t>(at - names.begin());
  }

  template <class Value>
  void add_once(std::map<std::string, Value>& words, const std::string& word, Value value) const {
    if (!words.emplace(word, value).second) fail("has \"" + word + "\" twice");
  }

  WordTable table_;
  std::set<std::string> lemmas_;
  std::string section_ = "the head";
  int line_ = 0;
};

}  // namespace

WordTable parse_word_table(const std::string& text) {
  return Parser().parse(text);
}

const WordTable& word_table() {
  static const WordTable table = parse_word_table(embedded_text(kFile));
  return table;
}

}  // namespace physmas::plan
