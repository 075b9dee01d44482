// The words that the built-in agent knows: verbs, directions, strengths, and the small words around them. They are
// listed in lib/plan/words/vocabulary.txt, which the build embeds.
#ifndef PHYSMAS_PLAN_VOCABULARY_H
#define PHYSMAS_PLAN_VOCABULARY_H

#include <optional>
#include <string>
#include <vector>

#include "records/actions.h"

namespace physmas::plan {

// What a verb asks for: one of the ten actions of the paper's Table "actions", or nothing that needs an action.
struct Meaning {
  enum class Kind {
    action,       // `type` says which
    gravity,      // gravity and the colliders of the run specification do it
    outcome,      // something that the simulation shows or does not show; nothing to command
    not_modelled  // what no branch of the solver does: `field` says what of
  } kind = Kind::outcome;
  ActionType type = ActionType::translation;
  bool tips = false;  // a torque about a horizontal axis: the thing is laid over
  std::string field;  // fracture, liquid, heat, life
};

struct Verb {
  std::string lemma;
  Meaning meaning;
  // Where the thing goes when the prompt does not say: "up", "down", "in" (a scale that makes smaller), or empty.
  std::string direction;
};

// The verb that a token is a form of; empty when it is none that we know.
std::optional<Verb> find_verb(const std::string& token);

// Directions as seen in the front view. `toward`: out of the image to the viewer; `away`: into the image.
enum class DirectionWord {
  none,
  up,
  down,
  left,
  right,
  toward,
  away,
  plus_x,
  minus_x,
  plus_y,
  minus_y,
  plus_z,
  minus_z,
  clockwise,  // as seen from above
  counterclockwise
};

// A place of a thing that has no part of that name: its upper end, its lower end, or somewhere else on it.
enum class Region { none, top, bottom, side };
Region find_region(const std::string& token);

// Index into kLabels (records/labels.h) of the material that a word means ("wooden", "jelly"); empty for other words.
std::optional<int> find_material(const std::string& token);

// The tokens with what several of them say together as one: "after that" is then, "into the air" upwards, "back and
// forth" to-and-fro, "up and down" up-and-down.
std::vector<std::string> replace_phrases(const std::vector<std::string>& tokens);

// "down", "leftwards", "forward", "+x", ...; none for other tokens. Whether a word such as "left" means a direction in
// its place is for the parser to judge.
DirectionWord find_direction(const std::string& token);
// The direction of something that comes from there: "from above" is down.
DirectionWord opposite(DirectionWord word);

// Factor on the default magnitude; 0 for tokens that say nothing about strength.
double strength_factor(const std::string& token);
// Factor of "very", "extremely", ... on the distance of the next strength word from 1; 0 for other tokens.
double intensifier(const std::string& token);

bool is_determiner(const std::string& token);
bool is_pronoun(const std::string& token);
bool is_auxiliary(const std::string& token);   // be, get, make, let, start, ...: no event of their own
bool makes_passive(const std::string& token);  // the forms of be and get
bool gives(const std::string& token);          // light verbs: "give it a push"
bool is_negation(const std::string& token);    // not, never, without
bool ends_clause(const std::string& token);    // and, then, while, "," ...
bool is_external(const std::string& noun);     // hand, someone, wind: acts from outside the scene
bool is_wind(const std::string& noun);         // wind, breeze, gust: its push is an impulse
bool is_ground(const std::string& noun);       // floor, table: what the run's colliders stand for
bool is_tool(const std::string& noun);         // hammer, stick, car: acts where something else is acted on
bool means_whole(const std::string& noun);     // object, thing: names nothing
bool is_general(const std::string& noun);      // plant, toy: a kind of thing
bool is_filler(const std::string& token);      // words that carry nothing for the plan

}  // namespace physmas::plan

#endif
