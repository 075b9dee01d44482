#include "plan/vocabulary.h"

#include <algorithm>
#include <initializer_list>
#include <map>

#include "base/words.h"

namespace physmas::plan {
namespace {

using Kind = Meaning::Kind;

// One line per meaning: regular verbs by lemma, irregular forms after a colon.
struct VerbLine {
  Meaning meaning;
  const char* direction;
  std::vector<const char*> verbs;
};

const std::vector<VerbLine>& verb_lines() {
  static const std::vector<VerbLine> kLines = {
      {{Kind::action, ActionType::translation},
       "",
       {"push",
        "shove",
        "slide:slid",
        "move",
        "throw:threw:thrown",
        "toss",
        "fling:flung",
        "hurl",
        "roll",
        "fly:flew:flown",
        "travel",
        "shift",
        "drive:drove:driven",
        "charge",
        "ram",
        "swing:swung",
        "carry",
        "translate",
        "glide",
        "speed:sped",
        "rush",
        "advance",
        "approach"}},
      {{Kind::action, ActionType::translation}, "up", {"lift", "raise", "rise:rose:risen", "hoist", "elevate"}},
      {{Kind::action, ActionType::translation}, "down", {"lower"}},
      {{Kind::action, ActionType::top_press},
       "down",
       {"press", "squash", "squish", "crush", "smush", "smash", "stomp", "trample", "depress"}},
      {{Kind::action, ActionType::impulse},
       "",
       {"hit",
        "strike:struck:stricken",
        "kick",
        "knock",
        "blow:blew:blown",
        "punch",
        "slap",
        "tap",
        "poke",
        "bump",
        "flick",
        "smack",
        "bat",
        "nudge",
        "jolt",
        "whack",
        "thump",
        "collide",
        "slam",
        "crash",
        "sway",
        "rock",
        "shake:shook:shaken",
        "bend:bent",
        "tilt",
        "lean:leant",
        "flutter",
        "impact"}},
      {{Kind::action, ActionType::impulse}, "up", {"jump", "hop", "leap:leapt"}},
      {{Kind::gravity, {}},
       "",
       {"fall:fell:fallen", "drop", "land", "topple", "tumble", "collapse", "plunge", "plummet", "descend",
        "sink:sank:sunk", "release", "slump", "sag", "droop", "settle"}},
      {{Kind::outcome, {}}, "", {"bounce",  "rebound",     "break:broke:broken",
                                 "shatter", "deform",      "splash",
                                 "spill",   "splatter",    "wobble",
                                 "jiggle",  "dent",        "crack",
                                 "rest",    "stay",        "remain",
                                 "sit:sat", "stand:stood", "lie:lay:lain",
                                 "stop",    "come:came",   "scatter"}},
      {{Kind::action, ActionType::radial_spread},
       "",
       {"spread:spread", "melt", "ooze", "expand", "dissolve", "liquefy", "explode", "burst", "smear"}},
      {{Kind::action, ActionType::vertical_compress}, "", {"compress", "flatten", "compact"}},
      {{Kind::action, ActionType::side_compress}, "", {"squeeze", "pinch", "clamp", "grip"}},
      {{Kind::action, ActionType::drag_pair}, "", {"drag", "tow", "haul", "pull", "tug"}},
      {{Kind::action, ActionType::scale}, "", {"stretch", "elongate", "extend", "lengthen", "inflate", "enlarge"}},
      {{Kind::action, ActionType::scale}, "in", {"shrink:shrank:shrunk", "shorten", "contract"}},
      {{Kind::action, ActionType::torque},
       "",
       {"twist", "spin:spun", "rotate", "turn", "twirl", "wring:wrung", "whirl", "swirl", "pivot"}},
      {{Kind::action, ActionType::support_hold},
       "",
       {"hold:held", "fix", "pin", "anchor", "grasp", "secure", "fasten"}},
  };
  return kLines;
}

std::map<std::string, Verb> make_verbs() {
  std::map<std::string, Verb> verbs;
  for (const VerbLine& line : verb_lines()) {
    for (const std::string entry : line.verbs) {
      const size_t colon = entry.find(':');
      const Verb verb = {entry.substr(0, colon), line.meaning, line.direction};
      std::vector<std::string> forms = verb_forms(verb.lemma);
      for (size_t at = colon; at != std::string::npos;) {
        const size_t next = entry.find(':', at + 1);
        forms.push_back(entry.substr(at + 1, next == std::string::npos ? next : next - at - 1));
        at = next;
      }
      for (const std::string& form : forms) verbs.emplace(form, verb);
    }
  }
  return verbs;
}

bool one_of(const std::string& token, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), token) != words.end();
}

}  // namespace

std::optional<Verb> find_verb(const std::string& token) {
  static const std::map<std::string, Verb> kVerbs = make_verbs();
  const auto found = kVerbs.find(token);
  if (found == kVerbs.end()) return std::nullopt;
  return found->second;
}

DirectionWord find_direction(const std::string& token) {
  static const std::map<std::string, DirectionWord> kWords = {
      {"up", DirectionWord::up},
      {"upward", DirectionWord::up},
      {"upwards", DirectionWord::up},
      {"above", DirectionWord::up},
      {"top", DirectionWord::up},
      {"down", DirectionWord::down},
      {"downward", DirectionWord::down},
      {"downwards", DirectionWord::down},
      {"below", DirectionWord::down},
      {"beneath", DirectionWord::down},
      {"underneath", DirectionWord::down},
      {"bottom", DirectionWord::down},
      {"left", DirectionWord::left},
      {"leftward", DirectionWord::left},
      {"leftwards", DirectionWord::left},
      {"right", DirectionWord::right},
      {"rightward", DirectionWord::right},
      {"rightwards", DirectionWord::right},
      {"sideways", DirectionWord::right},
      {"sideward", DirectionWord::right},
      {"horizontally", DirectionWord::right},
      {"forward", DirectionWord::toward},
      {"forwards", DirectionWord::toward},
      {"front", DirectionWord::toward},
      {"back", DirectionWord::away},
      {"behind", DirectionWord::away},
      {"backward", DirectionWord::away},
      {"backwards", DirectionWord::away},
      {"away", DirectionWord::away},
      {"+x", DirectionWord::plus_x},
      {"-x", DirectionWord::minus_x},
      {"+y", DirectionWord::plus_y},
      {"-y", DirectionWord::minus_y},
      {"+z", DirectionWord::plus_z},
      {"-z", DirectionWord::minus_z},
      {"clockwise", DirectionWord::clockwise},
      {"counterclockwise", DirectionWord::counterclockwise},
      {"anticlockwise", DirectionWord::counterclockwise},
  };
  const auto found = kWords.find(token);
  return found == kWords.end() ? DirectionWord::none : found->second;
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

double strength_factor(const std::string& token) {
  if (one_of(token, {"gently", "softly", "lightly", "slightly", "slowly", "gentle", "soft", "light", "slight", "slow",
                     "weakly", "weak", "carefully", "barely", "little", "delicately"}))
    return 0.5;
  if (one_of(token, {"hard", "strongly", "firmly", "forcefully", "fast", "quickly", "heavily", "strong", "firm",
                     "forceful", "quick", "heavy", "rapidly", "rapid", "swiftly", "sharply", "powerfully"}))
    return 2;
  if (one_of(token, {"violently", "fiercely", "violent", "fierce", "brutally", "furiously"})) return 3;
  return 0;
}

double intensifier(const std::string& token) {
  if (one_of(token, {"very", "really", "extremely", "super", "too"})) return 2;
  if (one_of(token, {"quite", "rather", "fairly", "somewhat"})) return 0.7;
  return 0;
}

bool is_determiner(const std::string& token) {
  return one_of(token,
                {"the",  "a",   "an",   "this", "that", "these", "those", "its",  "his",   "her",    "their",  "my",
                 "your", "our", "some", "one",  "each", "every", "all",   "both", "whole", "entire", "another"});
}

bool is_pronoun(const std::string& token) {
  return one_of(token, {"it", "them", "they", "itself", "themselves", "he", "she", "him"});
}

bool makes_passive(const std::string& token) {
  return one_of(token, {"is", "are", "was", "were", "be", "been", "being", "get", "gets", "got", "getting"});
}

bool is_auxiliary(const std::string& token) {
  return makes_passive(token) ||
         one_of(token,
                {"make",   "makes",   "let",    "lets",     "letting", "start", "starts", "begin", "begins", "cause",
                 "causes", "causing", "making", "have",     "has",     "had",   "do",     "does",  "did",    "will",
                 "would",  "should",  "must",   "can",      "could",   "may",   "might",  "keep",  "keeps",  "please",
                 "watch",  "show",    "see",    "simulate", "imagine", "try",   "tries"});
}

bool gives(const std::string& token) {
  return one_of(
      token, {"give", "gives", "gave", "given", "giving", "receive", "receives", "apply", "applies", "take", "takes"});
}

bool is_negation(const std::string& token) {
  return one_of(token, {"not", "never", "without", "doesn", "don", "isn", "no", "cannot"});
}

bool ends_clause(const std::string& token) {
  return one_of(token, {",", "and", "then", "while", "as", "so", "before", "because", "when", "until", "but", "which",
                        "who", "where", "or", "if"});
}

bool is_wind(const std::string& noun) {
  return one_of(noun, {"wind", "breeze", "gust", "storm", "air", "gale", "draft", "draught", "blast", "fan"});
}

bool is_external(const std::string& noun) {
  return is_wind(noun) ||
         one_of(noun, {"hand",   "finger", "fist",    "palm",   "thumb",     "foot",  "someone", "somebody",
                       "person", "man",    "woman",   "child",  "i",         "you",   "we",      "force",
                       "weight", "plate",  "press",   "thing",  "something", "user",  "player",  "boy",
                       "girl",   "people", "gravity", "piston", "camera",    "viewer"});
}

bool is_ground(const std::string& noun) {
  return one_of(noun, {"floor", "ground", "table", "tabletop", "surface", "desk", "earth", "grass", "bench", "counter",
                       "countertop", "wall", "shelf", "plane", "platform", "sand", "pavement", "road"});
}

bool is_filler(const std::string& token) {
  return one_of(token, {"there", "here",      "also",   "again", "once",   "twice",    "suddenly", "finally",
                        "just",  "only",      "now",    "first", "later",  "together", "straight", "directly",
                        "side",  "direction", "way",    "air",   "place",  "order",    "bit",      "amount",
                        "top",   "front",     "back",   "end",   "freely", "under",    "gravity",  "apart",
                        "open",  "over",      "motion", "force", "axis",   "along"});
}

ActionRange range_of(ActionType type) {
  static constexpr ActionRange kRanges[] = {
      {ActionType::translation, 0.6, 0.05, 3.0, 0.0, 0.5},   {ActionType::top_press, 0.15, 0.02, 0.6, 0.1, 0.6},
      {ActionType::radial_spread, 0.3, 0.05, 1.5, 0.1, 0.6}, {ActionType::vertical_compress, 0.6, 0.2, 1.0, 0.1, 0.6},
      {ActionType::side_compress, 0.65, 0.2, 1.0, 0.1, 0.6}, {ActionType::drag_pair, 0.4, 0.05, 2.0, 0.0, 0.5},
      {ActionType::scale, 1.5, 0.3, 3.0, 0.1, 0.6},          {ActionType::impulse, 1.5, 0.1, 6.0, 0.1, 0.0},
      {ActionType::torque, 2.0, 0.2, 12.0, 0.1, 0.6},        {ActionType::support_hold, 0.0, 0.0, 0.0, 0.0, 1.0},
  };
  return kRanges[static_cast<int>(type)];
}

bool is_ratio(ActionType type) {
  return type == ActionType::vertical_compress || type == ActionType::side_compress || type == ActionType::scale;
}

const char* magnitude_unit(ActionType type) {
  return is_ratio(type) ? "" : type == ActionType::torque ? " rad/s" : " m/s";
}

}  // namespace physmas::plan
