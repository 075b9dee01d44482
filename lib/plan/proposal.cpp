#include "plan/proposal.h"

#include "base/words.h"
#include "records/json.h"

namespace physmas::plan {

using Kind = Meaning::Kind;

Json proposal_of(const Reading& reading) {
  Json proposal = {{"agent", "builtin"}, {"events", Json::array()}};
  for (const Event& event : reading.events) {
    const Meaning& meaning = event.verb.meaning;
    Json entry = {{"verb", event.word},
                  {"meaning", meaning.kind == Kind::action    ? action_name(meaning.type)
                              : meaning.kind == Kind::gravity ? "gravity"
                              : meaning.kind == Kind::outcome ? "outcome"
                                                              : "not modelled"}};
    const auto add = [&](const char* name, const NounPhrase& phrase) {
      if (!phrase.empty()) entry[name] = join(phrase, " ");
    };
    add("subject", event.subject);
    add("object", event.object);
    add("by", event.agent);
    add("with", event.instrument);
    add("goal", event.goal);
    add("toward", event.toward);
    if (event.strength != 1) entry["strength"] = event.strength;
    if (event.speed) entry["speed"] = *event.speed;
    if (event.duration) entry["duration"] = *event.duration;
    if (event.delay) entry["delay"] = *event.delay;
    if (event.angle) entry["angle"] = *event.angle;
    if (event.tips) entry["tips"] = true;
    if (event.to_and_fro) entry["to_and_fro"] = true;
    if (event.apart) entry["apart"] = true;
    if (event.negated) entry["negated"] = true;
    proposal["events"].push_back(entry);
  }
  return proposal;
}

}  // namespace physmas::plan
