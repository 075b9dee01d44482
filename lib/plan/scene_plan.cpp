#include "plan/scene_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/words.h"
#include "plan/action_values.h"
#include "plan/prompt.h"
#include "plan/proposal.h"
#include "plan/scene_inventory.h"
#include "plan/timetable.h"
#include "records/labels.h"
#include "records/reference.h"

namespace physmas::plan {
namespace {

using Kind = Meaning::Kind;

// How far a thing is turned that is laid over; gravity takes it on.
constexpr double kTipAngle = 1.1;  // rad

std::string quoted(const NounPhrase& phrase) {
  return "\"" + join(phrase, " ") + "\"";
}

class Compiler {
 public:
  Compiler(const Inventory& inventory, const SceneGeometry& geometry, const RunSpecification& run, std::string file)
      : inventory_(inventory), geometry_(geometry), run_(run), file_(std::move(file)), timetable_(run) {
    one_part_ = std::count_if(inventory.rows.begin(), inventory.rows.end(),
                              [](const InventoryRow& row) { return !row.residual; }) == 1;
  }

  Plan compile(const std::string& prompt) {
    plan_.prompt = prompt;
    const Reading reading = read_prompt(prompt, nouns_of(inventory_));
    plan_.proposal = proposal_of(reading);
    for (const std::string& text : reading.not_understood) note(kNotUnderstood + ("\"" + text + "\""));
    sequential_ = std::any_of(reading.events.begin(), reading.events.end(), [](const Event& e) { return e.then; });
    for (const Event& event : reading.events) {
      compile_event(event);
      last_said_ = said_direction(event, geometry_);
    }
    timetable_.fit(plan_.actions);
    if (timetable_.factor() < 1) {
      note(fmt::format("one after the other does not fit into {} s: every step takes {:.2f} of its time",
                       run_.time.duration(), timetable_.factor()));
    }
    if (reading.events.empty()) note("no verb that the built-in agent knows: gravity only");
    plan_.still = plan_.actions.empty() && asks_for_stillness(reading);
    if (plan_.actions.empty())
      plan_.omitted.push_back({"actions", plan_.still ? "the prompt asks for no motion: gravity and the colliders only"
                                                      : "gravity and the colliders do what the prompt tells"});
    plan_.resolved = true;
    return std::move(plan_);
  }

 private:
  // "does not move", "stands still".
  static bool asks_for_stillness(const Reading& reading) {
    const auto still = [](const Event& event) {
      static const std::vector<std::string> kStill = {"rest", "stay", "remain", "sit", "stand", "lie", "stop"};
      return event.negated || std::find(kStill.begin(), kStill.end(), event.verb.lemma) != kStill.end();
    };
    return !reading.events.empty() && std::all_of(reading.events.begin(), reading.events.end(), still);
  }

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
    std::vector<std::string> found = find_references(inventory_, phrase);
    if (found.empty() && means_only_object(phrase)) {
      found = {inventory_.objects[0].id};
      if (!one_part_) note(fmt::format("{} taken as {}", quoted(phrase), found[0]));
    }
    if (found.size() > 1) {
      throw refused(fmt::format("{} with \"{}\", which fits {}", quoted(phrase), word_, join(found)),
                    "a name that fits one of them", "say which, as in \"the PART of the OBJECT\"");
    }
    if (found.empty()) return "";
    expect_material(found[0], phrase);
    return found[0];
  }

  // Hands, people, forces, tools.
  static bool acts_from_outside(const NounPhrase& phrase) {
    const std::string head = singular(phrase.back());
    return is_external(head) || is_tool(head);
  }

  // Where one part is all there is, what is no agent, no force, no tool and no floor can only be that; where one object
  // is, the names of things in general.
  bool means_only_object(const NounPhrase& phrase) const {
    const std::string head = singular(phrase.back());
    if (inventory_.objects.size() > 1 || acts_from_outside(phrase) || is_ground(head)) return false;
    return one_part_ || means_whole(head) || is_general(head);
  }

  // "a rubber bear": a word of material that is no part of the thing's own name tells what it is made of.
  void expect_material(const std::string& reference, const NounPhrase& phrase) {
    const int row = inventory_.find_row(reference);
    const std::string name = row >= 0 ? inventory_.rows[row].name + " " + inventory_.rows[row].part
                                      : inventory_.objects[inventory_.find_object(reference)].name;
    const std::vector<std::string> own = name_words(name);
    for (const std::string& word : phrase) {
      const std::optional<int> label = find_material(singular(word));
      const bool in_name = std::find(own.begin(), own.end(), singular(word)) != own.end();
      if (label && (!in_name || one_part_)) add_material(reference, *label, word);
    }
  }

  void add_material(const std::string& target, int label, const std::string& word) {
    const bool known = std::any_of(plan_.materials.begin(), plan_.materials.end(),
                                   [&](const PlanMaterial& m) { return m.target == target && m.label == label; });
    if (known) return;
    plan_.materials.push_back({target, label, word});
    note(fmt::format("\"{}\": {} is expected to be {}", word, target, kLabels[label].name));
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
    if (event.then) timetable_.next_stage();
    word_ = event.word;
    if (event.negated) return note(fmt::format("\"{}\" is negated: no action", event.word));
    for (const std::string& words : event.unused) note(fmt::format("not used: \"{}\"", words));
    const Meaning& meaning = event.verb.meaning;
    if (is_about_gravity(event)) {
      return note(kNotDone +
                  fmt::format("\"{}\" of gravity: it is a setting of the run, SET=\"gravity=[0,0,0]\" turns it off",
                              event.word));
    }
    if (meaning.kind == Kind::not_modelled) return note_not_modelled(event);
    if (becomes_material(event)) return;
    if (meaning.kind == Kind::outcome) {
      if (const std::string subject = resolve(event.subject); !subject.empty()) last_moved_ = subject;
      return note(fmt::format("\"{}\" is an outcome: the simulation decides it, no action", event.word));
    }
    if (meaning.kind == Kind::gravity && !event.tips) return compile_fall(event);
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
    if (tips(event)) return add_tip(event, patient);
    if (!mover.empty() && !same_object(mover, patient)) return compile_pair(event, type, mover, patient);
    const bool wind = !acting.empty() && is_wind(singular(acting.back()));
    if (type == ActionType::translation && wind) type = ActionType::impulse;
    if (type == ActionType::translation) {
      if (const std::string goal = obstacle(event.goal, patient); !goal.empty())
        return add_collision(event, patient, goal);
    }
    if (event.apart && (type == ActionType::drag_pair || type == ActionType::translation)) {
      type = ActionType::scale;
      note(kNotDone + fmt::format("\"{} apart\": {} is stretched and does not part", event.word, patient));
    }
    for (const std::string& part : patients) add_action(event, type, "", part);
    if (event.verb.lemma == "melt") soften(event, patients);
    if (patients.size() == 1) act_on_place(event, type, patient);
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

  // What melts is soft; of an object of several parts nobody said which.
  void soften(const Event& event, const std::vector<std::string>& patients) {
    for (const std::string& part : patients) {
      if (resolve_rows(inventory_, part).size() == 1 || one_part_) {
        add_material(part, kPlasticine, event.word);
      } else {
        note(fmt::format("\"{}\": the parts of {} keep their materials; MATERIAL= changes them", event.word, part));
      }
    }
  }

  // An end of the thing that is no part of its own: a slab there is held or turned. Other actions move all of it.
  void act_on_place(const Event& event, ActionType type, const std::string& patient) {
    if (plan_.actions.empty() || plan_.actions.back().type != type) return;  // it was planned already
    const Region region = find_region(event.place);
    const bool whole = patient.find('/') == std::string::npos || one_part_;
    PlanAction& action = plan_.actions.back();
    if (type == ActionType::support_hold && region != Region::none && region != Region::side && whole) {
      action.slab = true;
      action.direction = (region == Region::top ? 1 : -1) * geometry_.up + Eigen::Vector3d::Zero();
      return;
    }
    const bool twist = event.verb.lemma == "twist" || event.verb.lemma == "wring";
    if (type == ActionType::torque && whole && (twist || region == Region::top || region == Region::bottom)) {
      // The lower end turned one way is the upper end turned the other way.
      if (region == Region::bottom) action.direction = -action.direction + Eigen::Vector3d::Zero();
      return hold_against(event, patient);
    }
    const bool natural = type == ActionType::top_press || type == ActionType::side_compress || is_ratio(type);
    if (region != Region::none && !natural)
      note(fmt::format("\"{}\" is a place of {}, no part of the inventory: all of it is acted on", event.place,
                       patient));
  }

  // Something that is twisted as a whole has to be held at its other end.
  void hold_against(const Event& event, const std::string& patient) {
    PlanAction& torque = plan_.actions.back();
    torque.slab = true;
    for (const PlanAction& other : plan_.actions) {
      if (other.type == ActionType::support_hold && other.slab && other.target == patient) return;
    }
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

  static bool tips(const Event& event) { return event.tips || event.verb.meaning.tips; }

  // What is pushed over turns about a horizontal axis, so that its top goes where the prompt says; gravity does the
  // rest.
  void add_tip(const Event& event, const std::string& target) {
    // "leans to the left and falls over"
    Eigen::Vector3d way = event.directions.empty() ? last_said_ : said_direction(event, geometry_);
    way -= way.dot(geometry_.up) * geometry_.up;
    if (way.norm() < 1e-6) {
      note(fmt::format("no direction for \"{} over\": to the right of the front view", event.word));
      way = geometry_.right;
    }
    add_action(event, ActionType::torque, "", target);
    PlanAction& torque = plan_.actions.back();
    torque.direction = geometry_.up.cross(way.normalized()) + Eigen::Vector3d::Zero();
    torque.end = torque.start + event.angle.value_or(kTipAngle) / torque.magnitude;
  }

  static bool is_about_gravity(const Event& event) {
    for (const NounPhrase& phrase : {event.subject, event.object}) {
      if (!phrase.empty() && phrase.back() == "gravity" && event.verb.meaning.kind == Kind::action &&
          event.verb.meaning.type == ActionType::torque)
        return true;
    }
    return false;
  }

  void note_not_modelled(const Event& event) {
    const NounPhrase& phrase = event.passive || event.object.empty() ? event.subject : event.object;
    if (const std::string reference = resolve(phrase); !reference.empty()) last_moved_ = mentioned_ = reference;
    const std::string& field = event.verb.meaning.field;
    const char* why = field == "fracture" ? "nothing breaks or parts here; what yields, flows (MATERIAL=Sand crumbles)"
                      : field == "liquid" ? "there are no liquids here; what is inside moves as its material does"
                      : field == "heat"   ? "heat is not simulated"
                                          : "nothing moves by itself here";
    note(kNotDone + fmt::format("\"{}\": {}", event.word, why));
  }

  // "turn it to sand", "the cake becomes jelly".
  bool becomes_material(const Event& event) {
    const std::string& lemma = event.verb.lemma;
    if (lemma != "turn" && lemma != "change" && lemma != "transform" && lemma != "become") return false;
    for (const NounPhrase& phrase : {event.toward, event.goal, event.object}) {
      if (phrase.empty()) continue;
      const std::optional<int> label = find_material(singular(phrase.back()));
      if (!label) continue;
      const bool acted_on = event.passive || event.object.empty() || phrase == event.object;
      for (const std::string& part : require_all(acted_on ? event.subject : event.object, event)) {
        add_material(part, *label, phrase.back());
        last_moved_ = mentioned_ = part;
      }
      return true;
    }
    return false;
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
    if (!falling.empty() && acts_from_outside(falling)) {
      const std::string hit = resolve(event.goal.empty() ? event.toward : event.goal);
      if (resolve(falling).empty() && !hit.empty()) {
        note(kNotDone + fmt::format("{} is not in the scene and does not fall: {} is pressed from above instead",
                                    quoted(falling), hit));
        return add_action(event, ActionType::top_press, "", hit);
      }
    }
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
    if (tips(event)) return add_tip(event, mover);
    const ActionType type = pressed_type(event);
    std::string goal = obstacle(event.goal, mover);
    if (goal.empty() && type != ActionType::translation) goal = obstacle(event.toward, mover);
    if (!goal.empty()) return add_collision(event, mover, goal);
    if (type == ActionType::impulse && is_ground_target(event.goal)) return note_ground(event, event.goal);
    add_action(event, type, "", mover);
    if (event.verb.lemma == "melt") soften(event, {mover});
    act_on_place(event, type, mover);
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
    // Two nouns of the prompt may mean one thing ("a ficus: its leaves move").
    if (is_planned(action)) return;
    plan_.actions.push_back(action);
    if (event.to_and_fro) move_to_and_fro(event);
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

  bool is_planned(const PlanAction& action) const {
    return std::any_of(plan_.actions.begin(), plan_.actions.end(), [&](const PlanAction& other) {
      return other.type == action.type && other.source == action.source && other.target == action.target &&
             other.direction == action.direction && other.magnitude == action.magnitude &&
             other.start == action.start && other.end == action.end;
    });
  }

  // The last action as strokes that alternate: a driven motion swings about where it began.
  void move_to_and_fro(const Event& event) {
    PlanAction stroke = plan_.actions.back();
    if (stroke.type != ActionType::translation && stroke.type != ActionType::impulse &&
        stroke.type != ActionType::torque)
      return note(kNotDone + fmt::format("\"{}\" to and fro: once", event.word));
    plan_.actions.pop_back();
    // Where something comes after it, it has its usual time, else the run's.
    const double start = stroke.start, end = stroke.end, whole = sequential_ ? end : run_.time.duration();
    constexpr int kStrokes = 5;
    for (int k = 0; k < kStrokes; ++k) {
      if (stroke.type == ActionType::impulse) {
        stroke.start = start + k * (whole - start) / kStrokes;
        stroke.end = stroke.start + (end - start);
      } else {
        // Half a stroke out, whole strokes across, half a stroke back.
        const double unit = (whole - start) / (2 * kStrokes - 2);
        stroke.start = k == 0 ? start : plan_.actions.back().end;
        stroke.end = std::min(stroke.start + (k == 0 || k == kStrokes - 1 ? 1 : 2) * unit, whole);
      }
      plan_.actions.push_back(stroke);
      stroke.direction = -stroke.direction + Eigen::Vector3d::Zero();
    }
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
    if (!event.says_strength && !event.speed && type != ActionType::support_hold) {
      note(fmt::format("no strength for \"{}\": {}{}", event.word, magnitude,
                       is_ratio(type) ? " of its extent" : action_line(type).unit));
    }
    return magnitude;
  }

  void set_interval(const Event& event, PlanAction& action) {
    const double usual = action_line(action.type).end_fraction * run_.time.duration() - action_line(action.type).start;
    const bool driven = action.type == ActionType::translation && !action.source.empty();
    for (const std::string& text :
         timetable_.place(event, driven ? contact_time(action, geometry_, usual) : usual, action))
      note(text);
  }

  const Inventory& inventory_;
  const SceneGeometry& geometry_;
  const RunSpecification& run_;
  const std::string file_;
  Plan plan_;
  std::vector<std::string> fallen_;  // what an earlier event let fall
  std::string last_moved_, mentioned_;
  Eigen::Vector3d last_said_ = Eigen::Vector3d::Zero();  // the direction that the event before said
  std::string word_;                                     // the verb of the event that is compiled
  Timetable timetable_;
  bool sequential_ = false;  // something comes after something else
  bool one_part_ = false;    // all that is not residual is one row
};

}  // namespace

Plan plan_from_prompt(const std::string& prompt, const Inventory& inventory, const SceneGeometry& geometry,
                      const RunSpecification& run, const std::string& file) {
  return Compiler(inventory, geometry, run, file).compile(prompt);
}

}  // namespace physmas::plan
