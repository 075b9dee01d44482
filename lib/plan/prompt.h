// A motion prompt, read word by word: which events it tells of, in order, and what it says about each.
#ifndef PHYSMAS_PLAN_PROMPT_H
#define PHYSMAS_PLAN_PROMPT_H

#include <optional>
#include <string>
#include <vector>

#include "plan/vocabulary.h"
#include "records/reference.h"

namespace physmas::plan {

// One verb and what belongs to it. Phrases are empty where the prompt has none.
struct Event {
  Verb verb;
  std::string word;       // the verb as written
  NounPhrase subject;     // inherited from the event before where the clause has none of its own
  NounPhrase object;      // direct object
  NounPhrase agent;       // "by ...", which makes the event passive
  NounPhrase instrument;  // "with ..."
  NounPhrase goal;        // "into/against/onto/on/at/in ..."
  NounPhrase toward;      // "to/towards ..."
  bool passive = false;
  bool negated = false;
  bool then = false;        // told as coming after the event before
  bool tips = false;        // "over": the thing is laid over
  bool to_and_fro = false;  // "back and forth"
  bool apart = false;       // "pulled apart"
  std::string place;        // of what is acted on, where the prompt names one that is no part: "top", "headstock"
  std::vector<DirectionWord> directions;
  double strength = 1;  // factor on the default magnitude
  bool says_strength = false;
  std::optional<double> speed;      // "at 2 m/s"
  std::optional<double> duration;   // "for 1 second" [s]
  std::optional<double> delay;      // "after 0.5 s" [s]
  std::optional<double> angle;      // "by 90 degrees" [rad]
  std::vector<std::string> unused;  // what was read and says nothing to the plan: "5 kg", "from high"
};

struct Reading {
  std::vector<Event> events;
  std::vector<std::string> not_understood;  // clauses without a verb that we know
  NounPhrase first_noun;                    // the first noun phrase, whatever its clause says
  NounPhrase opening_noun;                  // that of a clause without a verb before the first event
};

// known_nouns: words (singular) of the names in the inventory; a word that is also a verb is a noun after a determiner
// or when it is one of these and another verb follows in its clause.
Reading read_prompt(const std::string& prompt, const std::vector<std::string>& known_nouns);

// Whether what happens first is a fall ("falls", "is dropped", "bounces"), or nothing is understood: such a scene
// starts above its floor. What is pushed, sways or does nothing stands on it.
bool starts_in_the_air(const std::string& prompt);

}  // namespace physmas::plan

#endif
