#include "plan/prompt.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/constants.h"
#include "base/words.h"

namespace physmas::plan {
namespace {

using Clause = std::vector<std::string>;

bool one_of(const std::string& token, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), token) != words.end();
}

bool is_number(const std::string& token) {
  return !token.empty() && token[0] >= '0' && token[0] <= '9';
}

bool is_unit(const std::string& token) {
  return one_of(token, {"m",  "cm",      "mm",    "meter", "meters", "metre",  "metres",  "kg",
                        "g",  "gram",    "grams", "kilo",  "kilos",  "n",      "newton",  "newtons",
                        "pa", "percent", "times", "s",     "sec",    "second", "seconds", "m/s"});
}

// "push over the vase" lays it over, as against "rolls over the table".
bool lays_over(const std::string& lemma) {
  return one_of(lemma, {"knock", "push", "kick", "blow", "tip", "turn", "bump", "shove", "nudge", "pull"});
}

// "without damage" says what the result looks like, not what happens.
bool starts_time(const Clause& c, size_t i) {
  return i + 1 < c.size() && one_of(c[i], {"for", "after", "at", "within", "during"}) && is_number(c[i + 1]);
}

// Reads one clause after another; what a clause leaves open is taken from the events before.
class Reader {
 public:
  explicit Reader(const std::vector<std::string>& known_nouns) : known_nouns_(known_nouns) {}

  Reading read(const std::string& prompt) {
    Clause clause;
    bool then = false;
    for (const std::string& token : replace_phrases(tokens_of(prompt))) {
      if (!ends_clause(token)) {
        clause.push_back(token);
        continue;
      }
      read_clause(clause, then);
      if (!clause.empty()) then = false;
      clause.clear();
      then = then || token == "then";
    }
    read_clause(clause, then);
    flush_pending();
    return std::move(reading_);
  }

 private:
  bool known(const std::string& token) const {
    return std::find(known_nouns_.begin(), known_nouns_.end(), singular(token)) != known_nouns_.end();
  }

  // Whether the verb-like token at i stands for a thing or a quality ("the press", "the falling hammer").
  bool used_as_noun(const Clause& c, size_t i, bool after_giving) const {
    if (after_giving) return false;
    if (i > 0 && is_determiner(c[i - 1])) return true;
    if (!known(c[i])) return false;
    for (size_t k = i + 1; k < c.size(); ++k) {
      if (find_verb(c[k])) return true;
    }
    return false;
  }

  // Positions of the verbs of a clause that tell of events.
  std::vector<size_t> verbs_of(const Clause& c) const {
    std::vector<size_t> verbs;
    bool giving = false;
    for (size_t i = 0; i < c.size(); ++i) {
      giving = giving || gives(c[i]);
      if (find_verb(c[i]) && !used_as_noun(c, i, giving)) verbs.push_back(i);
    }
    return verbs;
  }

  // Left and right are directions unless they single out a part ("the left leaf") or a side; top, front, ... need a
  // preposition.
  DirectionWord direction_at(const Clause& c, size_t i, bool after_preposition) const {
    const DirectionWord word = find_direction(c[i]);
    if (word == DirectionWord::none) return word;
    const bool place = one_of(c[i], {"top", "bottom", "front", "above", "below", "beneath", "underneath", "behind"});
    if (place && !after_preposition) return DirectionWord::none;
    const bool has_next = i + 1 < c.size();
    if (has_next && one_of(c[i], {"top", "bottom", "front", "back", "left", "right", "behind"})) {
      if (c[i] == "right" && c[i + 1] == "away") return DirectionWord::none;
      if (c[i + 1] == "of" || (known(c[i + 1]) && i > 0 && is_determiner(c[i - 1]))) return DirectionWord::none;
      if (!after_preposition && i > 0 && is_determiner(c[i - 1]) && find_region(c[i + 1]) == Region::side)
        return DirectionWord::none;
    }
    return word;
  }

  static bool content(const std::string& token) {
    return !is_determiner(token) && !is_auxiliary(token) && !gives(token) && !is_negation(token) && !is_filler(token) &&
           !is_number(token) && strength_factor(token) == 0 && intensifier(token) == 0;
  }

  // Words of c[begin, end) into the slots of `event`; `slot` is where plain nouns go first.
  void read_words(const Clause& c, size_t begin, size_t end, NounPhrase* slot, Event& event) {
    NounPhrase ignored;
    NounPhrase of_head;  // "the head of the hammer": the head waits until its owner is read
    NounPhrase* of_slot = nullptr;
    const auto close_of = [&] {
      if (of_slot != nullptr) of_slot->insert(of_slot->end(), of_head.begin(), of_head.end());
      of_slot = nullptr;
    };
    double emphasis = 0;
    std::string dropped;  // the phrase that says nothing to the plan, as far as it is read
    const auto drop = [&] {
      const bool says = dropped.find(' ') != std::string::npos && dropped != "under gravity";
      if (says) event.unused.push_back(dropped);
      dropped.clear();
    };
    const auto leave_out = [&](const std::string& words) {
      if (slot == &ignored && !dropped.empty()) {
        dropped += " " + words;
      } else {
        event.unused.push_back(words);
      }
    };
    for (size_t i = begin; i < end; ++i) {
      const std::string& token = c[i];
      if (starts_time(c, i)) {
        const auto [last, left_out] = read_quantity(c, i, event);
        if (!left_out.empty()) leave_out(left_out);
        i = last;
        continue;
      }
      if (is_number(token)) {
        const auto [last, left_out] = read_number(c, i, event);
        if (!left_out.empty()) leave_out(left_out);
        i = last;
        continue;
      }
      if (token == "to-and-fro" || token == "up-and-down") {
        event.to_and_fro = true;
        if (token == "up-and-down") event.directions.push_back(DirectionWord::up);
        continue;
      }
      if (token == "apart") {
        event.apart = true;
        continue;
      }
      if (token == "over" && is_laid_over(c, i, end, event)) {
        event.tips = true;
        continue;
      }
      const double more = intensifier(token);
      if (more > 0) {
        emphasis = more;
        continue;
      }
      if (const double factor = strength_factor(token); factor > 0) {
        event.strength = emphasis > 0 ? std::pow(factor, emphasis) : factor;
        event.says_strength = true;
        emphasis = 0;
        continue;
      }
      if (token == "not" || is_negation(token)) {
        event.negated = event.negated || token != "no";
        continue;
      }
      if (token == "of") {
        if (slot != &ignored && !slot->empty() && of_slot == nullptr) {
          of_head = *slot;
          slot->clear();
          of_slot = slot;
        }
        continue;
      }
      if (is_preposition(token)) {
        size_t next = i + 1;
        while (next < end && is_determiner(c[next])) ++next;
        if (one_of(token, {"from", "to", "toward", "towards", "on", "at"}) && next < end) {
          const DirectionWord word = direction_at(c, next, true);
          if (word != DirectionWord::none && !one_of(token, {"on", "at"})) {
            event.directions.push_back(token == "from" ? opposite(word) : word);
            i = next;
            continue;
          }
        }
        if (one_of(token, {"toward", "towards"}) && next < end && one_of(c[next], {"camera", "viewer"})) {
          event.directions.push_back(DirectionWord::toward);
          i = next;
          continue;
        }
        close_of();
        drop();
        slot = leads_to_wind(c, i, end) && event.agent.empty() ? &event.agent : slot_of(token, event, ignored);
        if (slot == &ignored) dropped = token;
        continue;
      }
      const DirectionWord word = direction_at(c, i, false);
      if (word != DirectionWord::none) {
        event.directions.push_back(word);
        continue;
      }
      if (find_region(token) != Region::none && !known(token)) {
        event.place = token;
        continue;
      }
      if (one_of(token, {"again", "twice", "thrice", "times", "repeatedly"})) {
        leave_out(token == "times" && i > begin ? c[i - 1] + " times" : token);
        continue;
      }
      if (!content(token)) continue;
      slot->push_back(token);
      if (slot == &ignored) dropped += " " + token;
    }
    close_of();
    drop();
  }

  // "in the wind", "by a strong gust of wind": what blows is an agent, whatever the preposition.
  static bool leads_to_wind(const Clause& c, size_t preposition, size_t end) {
    for (size_t i = preposition + 1; i < end && !is_preposition(c[i]); ++i) {
      if (is_wind(singular(c[i]))) return true;
    }
    return false;
  }

  // "knock over the vase", "the vase falls over"; not "slides over the table".
  static bool is_laid_over(const Clause& c, size_t over, size_t end, const Event& event) {
    const std::string& lemma = event.verb.lemma;
    if (over > 0 && find_verb(c[over - 1]) && lays_over(lemma)) return true;
    return (lays_over(lemma) || one_of(lemma, {"fall", "topple", "keel", "tilt", "lean"})) &&
           std::none_of(c.begin() + static_cast<long>(over) + 1, c.begin() + static_cast<long>(end), content);
  }

  // The position of an amount's last word, and what of it says nothing to the plan.
  using Amount = std::pair<size_t, std::string>;

  // "by 90 degrees", "5 kg", "2 m": an angle counts, other amounts have no scale here.
  static Amount read_number(const Clause& c, size_t i, Event& event) {
    const std::string unit = i + 1 < c.size() ? c[i + 1] : "";
    if (one_of(unit, {"degree", "degrees", "deg", "\u00b0"})) {
      event.angle = std::strtod(c[i].c_str(), nullptr) * kPi / 180;
      return {i + 1, ""};
    }
    return is_unit(unit) ? Amount(i + 1, c[i] + " " + unit) : Amount(i, c[i]);
  }

  static bool is_preposition(const std::string& token) {
    return one_of(token, {"by",     "into",    "against", "onto",   "on",   "upon",   "at",    "in",  "through",
                          "to",     "toward",  "towards", "from",   "with", "using",  "via",   "off", "across",
                          "around", "between", "under",   "near",   "next", "beside", "along", "for", "after",
                          "over",   "inside",  "within",  "during", "like", "until",  "out"});
  }

  // The first phrase of a kind counts.
  static NounPhrase* slot_of(const std::string& preposition, Event& event, NounPhrase& ignored) {
    NounPhrase* slot = &ignored;
    if (preposition == "by") slot = &event.agent;
    if (one_of(preposition, {"with", "using", "via"})) slot = &event.instrument;
    if (one_of(preposition, {"into", "against", "onto", "on", "upon", "at", "in", "through", "over"}))
      slot = &event.goal;
    if (one_of(preposition, {"to", "toward", "towards"})) slot = &event.toward;
    return slot->empty() ? slot : &ignored;
  }

  // What the clauses before the first verb said about it ("from above, press the cake").
  Event take_opening() {
    Event opening;
    std::swap(opening, opening_);
    return opening;
  }

  // "at 2 m/s", "for 1.5 seconds", "after 0.5 s".
  static Amount read_quantity(const Clause& c, size_t i, Event& event) {
    const double value = std::strtod(c[i + 1].c_str(), nullptr);
    const std::string unit = i + 2 < c.size() ? c[i + 2] : "";
    if (unit == "m/s" || one_of(unit, {"meter", "meters", "metre", "metres"})) {
      event.speed = value;
      return {unit == "m/s" ? i + 2 : std::min(i + 4, c.size() - 1), ""};
    }
    if (one_of(unit, {"s", "sec", "secs", "second", "seconds"})) {
      (c[i] == "after" || c[i] == "at" ? event.delay : event.duration) = value;
      return {i + 2, ""};
    }
    const auto [last, left_out] = read_number(c, i + 1, event);
    return {last, left_out.empty() ? "" : c[i] + " " + left_out};
  }

  void read_clause(const Clause& c, bool then) {
    if (c.empty()) return;
    const std::vector<size_t> verbs = verbs_of(c);
    if (verbs.empty()) return read_without_verb(c);
    // Places named before the verb only say which thing is meant ("the ball on the table rolls").
    Event first = take_opening();
    NounPhrase before;
    read_words(c, 0, verbs[0], &before, first);
    first.agent = first.instrument = first.goal = first.toward = {};
    note_noun(before);
    for (size_t k = 0; k < verbs.size(); ++k) {
      const size_t end = k + 1 < verbs.size() ? verbs[k + 1] : c.size();
      Event event = k == 0 ? first : Event();
      event.verb = *find_verb(c[verbs[k]]);
      event.word = c[verbs[k]];
      event.then = then;
      event.passive = is_passive(c, verbs[k]);
      read_words(c, verbs[k] + 1, end, &event.object, event);
      if (!event.agent.empty()) event.passive = true;
      if (k == 0) {
        event.subject = before;
        take_given_noun(c, verbs[0], event);
      } else {
        const Event& previous = reading_.events.back();
        event.subject = previous.object.empty() ? previous.subject : previous.object;
        if (event.place.empty() && previous.object.empty()) event.place = previous.place;
      }
      const bool inherited = event.subject.empty() && !reading_.events.empty() && !is_imperative(c, verbs[k]);
      if (inherited) event.subject = subject_after(reading_.events.back());
      note_noun(event.object);
      add_event(event);
    }
  }

  // "give the ball a push": the thing stands before the event's noun and is its object.
  static void take_given_noun(const Clause& c, size_t verb, Event& event) {
    size_t giver = verb;
    while (giver > 0 && !gives(c[giver])) --giver;
    if (!gives(c[giver]) || giver == verb) return;
    NounPhrase given;
    for (size_t i = giver + 1; i < verb; ++i) {
      if (content(c[i])) given.push_back(c[i]);
    }
    event.subject.clear();
    event.object = !given.empty() ? given : !event.toward.empty() ? event.toward : event.goal;
    if (given.empty()) event.toward.clear();
  }

  // A clause that starts with the plain verb, adverbs aside: "gently press ...".
  static bool is_imperative(const Clause& c, size_t verb) {
    const Verb entry = *find_verb(c[verb]);
    if (c[verb] != entry.lemma) return false;
    for (size_t i = 0; i < verb; ++i) {
      if (content(c[i])) return false;
    }
    return true;
  }

  static bool is_passive(const Clause& c, size_t verb) {
    const std::string& word = c[verb];
    if (word.size() > 3 && word.compare(word.size() - 3, 3, "ing") == 0) return false;
    for (size_t i = verb; i > 0; --i) {
      if (makes_passive(c[i - 1])) return true;
      if (content(c[i - 1])) return false;
    }
    return false;
  }

  // Who acts next when nobody is named: the one who moved in the event before.
  static NounPhrase subject_after(const Event& event) {
    if (event.passive) return event.subject;
    const bool subject_moves = event.object.empty() || event.verb.meaning.kind == Meaning::Kind::outcome;
    if (subject_moves || !event.subject.empty()) return event.subject;
    return event.object;
  }

  // Nouns without a verb belong to the next verb as further subjects or to the last one as further objects; words of
  // direction and strength belong to the last verb.
  void read_without_verb(const Clause& c) {
    Event rest;
    NounPhrase nouns;
    read_words(c, 0, c.size(), &nouns, rest);
    note_noun(nouns);
    if (reading_.events.empty()) {
      opening_ = rest;
    } else {
      Event& last = reading_.events.back();
      last.directions.insert(last.directions.end(), rest.directions.begin(), rest.directions.end());
      if (rest.strength != 1) last.strength = rest.strength;
      if (rest.speed) last.speed = rest.speed;
      if (rest.duration) last.duration = rest.duration;
      if (rest.delay) last.delay = rest.delay;
      if (!rest.toward.empty()) last.toward = rest.toward;
      if (!rest.goal.empty()) last.goal = rest.goal;
      last.to_and_fro = last.to_and_fro || rest.to_and_fro;
      last.unused.insert(last.unused.end(), rest.unused.begin(), rest.unused.end());
    }
    if (nouns.empty()) return;
    if (reading_.events.empty() && reading_.opening_noun.empty()) reading_.opening_noun = nouns;
    pending_.push_back(nouns);
    pending_text_.push_back(join(c, " "));
  }

  void add_event(const Event& event) {
    for (const NounPhrase& nouns : pending_) {
      Event sibling = event;
      sibling.subject = nouns;
      reading_.events.push_back(sibling);
    }
    pending_.clear();
    pending_text_.clear();
    reading_.events.push_back(event);
  }

  void flush_pending() {
    if (!reading_.events.empty() && !reading_.events.back().object.empty()) {
      const Event last = reading_.events.back();
      for (size_t i = 0; i < pending_.size(); ++i) {
        if (!std::all_of(pending_[i].begin(), pending_[i].end(), [&](const std::string& w) { return known(w); })) {
          reading_.not_understood.push_back(pending_text_[i]);
          continue;
        }
        Event sibling = last;
        sibling.object = pending_[i];
        reading_.events.push_back(sibling);
      }
      return;
    }
    reading_.not_understood.insert(reading_.not_understood.end(), pending_text_.begin(), pending_text_.end());
  }

  void note_noun(const NounPhrase& nouns) {
    if (!reading_.first_noun.empty() || nouns.empty() || is_pronoun(nouns.front()) ||
        is_external(singular(nouns.back())))
      return;
    reading_.first_noun = nouns;
  }

  const std::vector<std::string>& known_nouns_;
  Reading reading_;
  Event opening_;
  std::vector<NounPhrase> pending_;
  std::vector<std::string> pending_text_;
};

}  // namespace

Reading read_prompt(const std::string& prompt, const std::vector<std::string>& known_nouns) {
  return Reader(known_nouns).read(prompt);
}

bool starts_in_the_air(const std::string& prompt) {
  const Reading reading = read_prompt(prompt, {});
  if (reading.events.empty()) return true;
  const Event& first = reading.events.front();
  const bool bounces = one_of(first.verb.lemma, {"bounce", "rebound"});
  return !first.negated && !first.tips && (first.verb.meaning.kind == Meaning::Kind::gravity || bounces);
}

}  // namespace physmas::plan
