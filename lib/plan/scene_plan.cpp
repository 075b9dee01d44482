#include "plan/scene_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/words.h"
#include "plan/action_values.h"
#include "plan/prompt.h"
#include "plan/proposal.h"
#include "plan/scene_inventory.h"
#include "records/reference.h"

namespace physmas::plan {
namespace {

using Kind = Meaning::Kind;

std::string quoted(const NounPhrase& phrase) {
  return "\"" + join(phrase, " ") + "\"";
}

class Compiler {
 public:
  Compiler(const Inventory& inventory, const SceneGeometry& geometry, const RunSpecification& run, std::string file)
      : inventory_(inventory), geometry_(geometry), run_(run), file_(std::move(file)) {}

  Plan compile(const std::string& prompt) {
    plan_.prompt = prompt;
    const Reading reading = read_prompt(prompt, nouns_of(inventory_));
    plan_.proposal = proposal_of(reading);
    for (const std::string& text : reading.not_understood) note(kNotUnderstood + ("\"" + text + "\""));
    for (const Event& event : reading.events) compile_event(event);
    if (reading.events.empty()) note("no verb that the built-in agent knows: gravity only");
    if (plan_.actions.empty())
      plan_.omitted.push_back({"actions", "gravity and the colliders do what the prompt tells"});
    plan_.resolved = true;
    return std::move(plan_);
  }

 private:
  void note(const std::string& text) {
    if (std::find(plan_.corrections.begin(), plan_.corrections.end(), text) == plan_.corrections.end())
      plan_.corrections.push_back(text);
  }

  Error refused(const std::string& found, const std::string& expected, const std::string& fix) const {
    return invalid_input({file_, "/prompt", found, expected, fix});
  }

  // The reference that a phrase means; empty when the inventory has none. A phrase that fits several is an Error.
  std::string resolve(const NounPhrase& phrase) {
    if (phrase.empty()) return "";
    if (is_pronoun(phrase.back())) return mentioned_;
    const std::vector<std::string> found = find_references(inventory_, phrase);
    if (found.size() > 1) {
      throw refused(fmt::format("{} with \"{}\", which fits {}", quoted(phrase), word_, join(found)),
                    "a name that fits one of them", "say which, as in \"the PART of the OBJECT\"");
    }
    return found.empty() ? "" : found[0];
  }

  // As resolve, for a thing that an action needs.
  std::string require(const NounPhrase& phrase, const Event& event) {
    const std::string reference = resolve(phrase);
    if (!reference.empty()) return reference;
    if (phrase.empty() || is_pronoun(phrase.back())) {
      if (!last_moved_.empty()) return last_moved_;
      if (inventory_.objects.size() == 1) return inventory_.objects[0].id;
      throw refused(fmt::format("\"{}\" without the thing that it is done to", event.word),
                    "one of " + join(all_references(inventory_)), "");
    }
    throw refused(fmt::format("{} as what \"{}\" acts on", quoted(phrase), event.word),
                  "one of " + join(all_references(inventory_)),
                  "use a name of the inventory, or give the scene an inventory that has it");
  }

  // As require, for what may be several parts at once.
  std::vector<std::string> require_all(const NounPhrase& phrase, const Event& event) {
    const std::vector<std::string> group = find_group(inventory_, phrase);
    if (group.size() > 1) note(quoted(phrase) + " taken as " + join(group));
    if (!group.empty()) return group;
    return {require(phrase, event)};
  }

  bool same_object(const std::string& a, const std::string& b) const { return object_of(a) == object_of(b); }

  bool is_ground_object(const std::string& reference) const {
    const InventoryObject& object = inventory_.objects[inventory_.find_object(object_of(reference))];
    const std::vector<std::string> words = name_words(object.name);
    return !words.empty() && is_ground(words.back());
  }

  // An object of the scene that `phrase` names, other than `self` and other than the ground: something to run into.
  std::string obstacle(const NounPhrase& phrase, const std::string& self) {
    const std::string reference = resolve(phrase);
    if (reference.empty() || is_ground_object(reference) || (!self.empty() && same_object(reference, self))) return "";
    return reference;
  }

  void compile_event(const Event& event) {
    actions_before_ = plan_.actions.size();
    word_ = event.word;
    if (event.negated) return note(fmt::format("\"{}\" is negated: no action", event.word));
    const Meaning& meaning = event.verb.meaning;
    if (meaning.kind == Kind::outcome) {
      if (const std::string subject = resolve(event.subject); !subject.empty()) last_moved_ = subject;
      return note(fmt::format("\"{}\" is an outcome: the simulation decides it, no action", event.word));
    }
    if (meaning.kind == Kind::gravity) return compile_fall(event);
    // Who acts, and on what; a mover is an object of the scene that acts on another.
    const NounPhrase& acting = event.passive ? event.agent : event.subject;
    NounPhrase acted_on = event.passive ? event.subject : event.object;
    std::string mover = resolve(event.instrument);
    if (mover.empty()) mover = resolve(acting);
    const bool ergative = !event.passive && event.object.empty();
    if (ergative && !mover.empty()) return compile_own_motion(event, mover);
    if (ergative) acted_on = !event.goal.empty() && !is_ground_word(event.goal) ? event.goal : event.object;
    if (ergative && acted_on.empty() && !event.subject.empty() && !is_external(event.subject.back()))
      acted_on = event.subject;
    if (is_ground_target(acted_on)) return note_ground(event, acted_on);
    const std::vector<std::string> patients = require_all(acted_on, event);
    const std::string& patient = patients.front();
    ActionType type = pressed_type(event);
    if (!mover.empty() && !same_object(mover, patient)) return compile_pair(event, type, mover, patient);
    const bool wind = !acting.empty() && is_wind(singular(acting.back()));
    if (type == ActionType::translation && wind) type = ActionType::impulse;
    if (type == ActionType::translation) {
      if (const std::string goal = obstacle(event.goal, patient); !goal.empty())
        return add_collision(event, patient, goal);
    }
    for (const std::string& part : patients) add_action(event, type, "", part);
    if (patients.size() == 1) hold_against(event, type, patient);
  }

  // What one object of the scene does to another.
  void compile_pair(const Event& event, ActionType type, const std::string& mover, const std::string& patient) {
    switch (type) {
      case ActionType::drag_pair:
        return add_action(event, type, mover, patient);
      case ActionType::support_hold:
        note(fmt::format("\"{}\": {} is held, and holds {} by contact", event.word, mover, patient));
        return add_action(event, type, "", mover);
      case ActionType::radial_spread:
      case ActionType::vertical_compress:
      case ActionType::scale:
      case ActionType::torque:
        note(fmt::format("\"{}\" is done to {}; {} itself is not moved", event.word, patient, mover));
        return add_action(event, type, "", patient);
      default:
        return add_collision(event, mover, patient);
    }
  }

  // Something that is twisted as a whole has to be held at its other end.
  void hold_against(const Event& event, ActionType type, const std::string& patient) {
    const bool twist = event.verb.lemma == "twist" || event.verb.lemma == "wring";
    if (type != ActionType::torque || !twist || patient.find('/') != std::string::npos) return;
    PlanAction& torque = plan_.actions.back();
    torque.slab = true;
    PlanAction hold = torque;
    hold.type = ActionType::support_hold;
    // The slab of a torque is at the upper end of a standing axis, whichever way it turns.
    const double upwards = torque.direction.dot(geometry_.up);
    hold.direction = (upwards < -1e-9 ? torque.direction : -torque.direction) + Eigen::Vector3d::Zero();
    hold.magnitude = 0;
    hold.role = "support";
    hold.start = 0;
    hold.end = run_.time.duration();
    plan_.actions.push_back(hold);
    note(fmt::format("\"{}\": one end of {} is turned, the other is held", event.word, patient));
  }

  static bool is_ground_word(const NounPhrase& phrase) { return !phrase.empty() && is_ground(singular(phrase.back())); }

  bool is_ground_target(const NounPhrase& phrase) {
    if (phrase.empty() || is_pronoun(phrase.back())) return false;
    const std::string reference = resolve(phrase);
    return reference.empty() ? is_ground_word(phrase) : inventory_.objects.size() > 1 && is_ground_object(reference);
  }

  void note_ground(const Event& event, const NounPhrase& ground) {
    note(fmt::format("\"{}\" on {}: gravity and the colliders do it, no action", event.word, quoted(ground)));
  }

  // Pushing down is pressing, pressing sideways is squeezing.
  static ActionType pressed_type(const Event& event) {
    const ActionType type = event.verb.meaning.type;
    const auto says = [&](DirectionWord word) {
      return std::find(event.directions.begin(), event.directions.end(), word) != event.directions.end();
    };
    if (event.verb.lemma == "push" && says(DirectionWord::down)) return ActionType::top_press;
    const bool sideways = says(DirectionWord::left) || says(DirectionWord::right) || says(DirectionWord::toward) ||
                          says(DirectionWord::away);
    if (type == ActionType::top_press && sideways && !says(DirectionWord::down)) return ActionType::side_compress;
    return type;
  }

  // "falls (onto Y)": gravity does it; falling onto another object of the scene is a driven collision.
  void compile_fall(const Event& event) {
    const NounPhrase& falling = event.passive || event.object.empty() ? event.subject : event.object;
    const std::string faller = resolve(falling);
    const std::string goal = obstacle(event.goal.empty() ? event.toward : event.goal, faller);
    if (!faller.empty() && !goal.empty()) {
      fallen_.push_back(faller);
      return add_collision(event, faller, goal);
    }
    if (!faller.empty()) {
      fallen_.push_back(faller);
      last_moved_ = mentioned_ = faller;
    }
    if (faller.empty() && !falling.empty() && !is_pronoun(falling.back()))
      note(fmt::format("{} is not in the inventory: gravity acts on the whole scene", quoted(falling)));
    note(fmt::format("\"{}\": gravity and the colliders of the run specification do it, no action", event.word));
  }

  // "the ball rolls into the glass", "the flower sways", "the hammer strikes".
  void compile_own_motion(const Event& event, const std::string& mover) {
    const ActionType type = pressed_type(event);
    std::string goal = obstacle(event.goal, mover);
    if (goal.empty() && type != ActionType::translation) goal = obstacle(event.toward, mover);
    if (!goal.empty()) return add_collision(event, mover, goal);
    if (type == ActionType::impulse && is_ground_target(event.goal)) return note_ground(event, event.goal);
    add_action(event, type, "", mover);
  }

  // `mover` is driven into `target`: a translation that specifies an impact (readings, "Candidates").
  void add_collision(const Event& event, const std::string& mover, const std::string& target) {
    for (const PlanAction& action : plan_.actions) {
      if (action.source == mover && action.target == target) {
        mentioned_ = target;
        return note(fmt::format("\"{}\": {} is driven into {} already", event.word, mover, target));
      }
    }
    add_action(event, ActionType::translation, mover, target);
    mentioned_ = target;
    last_moved_ = mover;
  }

  void add_action(const Event& event, ActionType type, const std::string& source, const std::string& target) {
    PlanAction action;
    action.type = type;
    action.source = source;
    action.target = target;
    action.impact = type == ActionType::impulse || (!source.empty() && !same_object(source, target));
    action.direction = direction_of(event, action) + Eigen::Vector3d::Zero();  // no negative zeros
    action.magnitude = magnitude_of(event, type);
    if (type == ActionType::support_hold) action.role = "support";
    if (type == ActionType::drag_pair && !source.empty()) action.follow = Follow::target;
    set_interval(event, action);
    plan_.actions.push_back(action);
    if (type == ActionType::side_compress && said_direction(event, geometry_).norm() < 1e-6) {
      // Squeezed from both sides, each goes half of the way.
      PlanAction& first = plan_.actions.back();
      first.magnitude = 0.5 * (1 + first.magnitude);
      PlanAction second = first;
      second.direction = -first.direction + Eigen::Vector3d::Zero();
      plan_.actions.push_back(second);
    }
    last_moved_ = source.empty() ? target : source;
    mentioned_ = target;
  }

  Eigen::Vector3d direction_of(const Event& event, const PlanAction& action) {
    if (const Eigen::Vector3d fixed = own_direction(event, action.type, geometry_); fixed.norm() > 0) return fixed;
    const Eigen::Vector3d sum = said_direction(event, geometry_);
    if (sum.norm() > 1e-6) return sum.normalized();
    const std::string& moved = action.source.empty() ? action.target : action.source;
    if (!event.directions.empty()) note(fmt::format("the directions of \"{}\" cancel out", event.word));
    const bool falls = std::find(fallen_.begin(), fallen_.end(), moved) != fallen_.end();
    if (!action.source.empty() && (falls || event.verb.direction == "down")) return -geometry_.up;
    std::string toward = action.source.empty() ? resolve(event.toward) : action.target;
    if (toward.empty() && action.source.empty()) toward = resolve(event.goal);
    if (!toward.empty() && !same_object(toward, moved)) {
      const Eigen::Vector3d way = between(moved, toward);
      if (way.norm() > 1e-9) return way.normalized();
      note(fmt::format("the masks do not tell where {} is as seen from {}: to the right", toward, moved));
      return geometry_.right;
    }
    if (!event.toward.empty()) note(fmt::format("{} is not in the inventory", quoted(event.toward)));
    if (event.verb.direction == "up") return geometry_.up;
    if (event.verb.direction == "down") return -geometry_.up;
    note(fmt::format("no direction for \"{}\": to the right of the front view", event.word));
    return geometry_.right;
  }

  // Scene units; zero when one of them was not measured.
  Eigen::Vector3d between(const std::string& from, const std::string& to) const {
    const auto a = geometry_.boxes.find(from), b = geometry_.boxes.find(to);
    if (a == geometry_.boxes.end() || b == geometry_.boxes.end()) return Eigen::Vector3d::Zero();
    return b->second.center - a->second.center;
  }

  double magnitude_of(const Event& event, ActionType type) {
    std::vector<std::string> corrections;
    const double magnitude = bounded_magnitude(type, wanted_magnitude(event, type), corrections);
    for (const std::string& correction : corrections) note(correction);
    return magnitude;
  }

  void set_interval(const Event& event, PlanAction& action) {
    const ActionLine& range = action_line(action.type);
    const double whole = run_.time.duration();
    action.start = event.delay ? *event.delay : std::min(range.start, 0.1 * whole);
    if (event.then && !event.delay && actions_before_ > 0) action.start = plan_.actions[actions_before_ - 1].end;
    if (action.start > whole) {
      note(fmt::format("{} starts at {} s, after the run's end: moved to {} s", action_name(action.type), action.start,
                       0.5 * whole));
      action.start = 0.5 * whole;
    }
    double length = range.end_fraction * whole - range.start;
    if (action.type == ActionType::impulse) {
      length = kImpulseSubsteps * run_.time.substep_dt;
    } else if (event.duration) {
      length = *event.duration;
    } else if (action.type == ActionType::translation && !action.source.empty()) {
      length = contact_time(action, geometry_, length);
    }
    action.end = std::min(action.start + std::max(length, 0.0), whole);
    if (event.duration && action.type != ActionType::impulse && action.start + *event.duration > whole)
      note(fmt::format("{} cut at the run's end, {} s", action_name(action.type), whole));
  }

  const Inventory& inventory_;
  const SceneGeometry& geometry_;
  const RunSpecification& run_;
  const std::string file_;
  Plan plan_;
  std::vector<std::string> fallen_;  // what an earlier event let fall
  std::string last_moved_, mentioned_;
  std::string word_;           // the verb of the event that is compiled
  size_t actions_before_ = 0;  // actions of earlier events
};

}  // namespace

Plan plan_from_prompt(const std::string& prompt, const Inventory& inventory, const SceneGeometry& geometry,
                      const RunSpecification& run, const std::string& file) {
  return Compiler(inventory, geometry, run, file).compile(prompt);
}

}  // namespace physmas::plan
