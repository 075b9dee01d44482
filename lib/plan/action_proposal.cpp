#include "plan/action_proposal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/words.h"
#include "plan/action_values.h"
#include "records/json.h"
#include "records/reference.h"
#include "remote/exchange.h"

namespace physmas::plan {
namespace {

constexpr double kNoDirection = 1e-6;  // a vector shorter than this points nowhere
const char* const kDirectionForms =
    "up, down, left, right, forward, back, clockwise, counterclockwise, +x ... -z, \"toward ID\", or three numbers";

class Compiler {
 public:
  Compiler(const Inventory& inventory, const SceneGeometry& geometry, const RunSpecification& run)
      : inventory_(inventory), geometry_(geometry), run_(run) {}

  Plan compile(const Json& proposal, const std::string& prompt) {
    plan_.prompt = prompt;
    plan_.proposal = {{"agent", "chat model"}};
    plan_.proposal.update(proposal);
    for (const Json& action : proposal.at("actions")) {
      where_ = fmt::format("/actions/{} ({})", plan_.actions.size(), action.at("type").get<std::string>());
      plan_.actions.push_back(compile_action(action));
    }
    if (plan_.actions.empty())
      plan_.omitted.push_back({"actions", "gravity and the colliders do what the prompt tells"});
    plan_.resolved = true;
    return std::move(plan_);
  }

 private:
  void note(const std::string& text) { plan_.corrections.push_back(where_ + ": " + text); }

  Error refused(const char* field, const Json& found, const std::string& expected) const {
    return remote::provider_error(
        where_, fmt::format("{}: found {}, expected {}", field, one_line(found.dump(), 120), one_line(expected, 600)));
  }

  std::string resolve(const char* field, const std::string& text, const Json& found) {
    const std::vector<std::string> all = all_references(inventory_);
    if (std::find(all.begin(), all.end(), text) != all.end()) return text;
    const std::vector<std::string> fitting = find_references(inventory_, name_words(text));
    if (fitting.size() == 1) {
      note(fmt::format("{} \"{}\" taken as {}", field, one_line(text, 80), fitting[0]));
      return fitting[0];
    }
    throw refused(field, found, "one of " + join(fitting.empty() ? all : fitting));
  }

  PlanAction compile_action(const Json& json) {
    PlanAction action;
    action.type = action_from(json.at("type").get<std::string>());
    action.target = resolve("target", json.at("target").get<std::string>(), json.at("target"));
    if (!json.at("source").is_null()) {
      if (!action_line(action.type).moved)
        throw refused("source", json.at("source"), "null: this action changes the target itself");
      action.source = resolve("source", json.at("source").get<std::string>(), json.at("source"));
      if (action.source == action.target)
        throw refused("source", json.at("source"), "another object or part than the target, or null");
    }
    action.role = json.at("role").get<std::string>();
    if ((action.role == "support") != (action.type == ActionType::support_hold))
      throw refused("role", json.at("role"), "\"support\" for support_hold, \"target\" for every other action");
    action.direction = direction_of(json.at("direction"), action) + Eigen::Vector3d::Zero();  // no negative zeros
    std::vector<std::string> corrections;
    const Json& magnitude = json.at("magnitude");
    action.magnitude = bounded_magnitude(
        action.type, magnitude.is_null() ? action_line(action.type).magnitude : magnitude.get<double>(), corrections);
    for (const std::string& correction : corrections) note(correction);
    action.impact = action.type == ActionType::impulse ||
                    (!action.source.empty() && object_of(action.source) != object_of(action.target));
    if (action.type == ActionType::drag_pair && !action.source.empty()) action.follow = Follow::target;
    set_interval(json, action);
    return action;
  }

  // What words say: the sum of their directions, or the way to a thing. Unknown words are refused.
  Eigen::Vector3d spoken_direction(const Json& json, const PlanAction& action, Event& event) {
    std::vector<std::string> tokens = tokens_of(json.get<std::string>());
    const auto is_any = [](const std::string& word, std::initializer_list<const char*> words) {
      return std::find(words.begin(), words.end(), word) != words.end();
    };
    tokens.erase(std::remove_if(tokens.begin(), tokens.end(),
                                [&](const std::string& t) {
                                  return is_determiner(t) || is_any(t, {",", ".", "and"});
                                }),
                 tokens.end());
    bool from = false;
    for (size_t i = 0; i < tokens.size(); ++i) {
      const std::string& token = tokens[i];
      const DirectionWord word = find_direction(token);
      if (word != DirectionWord::none) {
        event.directions.push_back(from ? opposite(word) : word);
      } else if (token == "from") {
        from = true;
      } else if (is_any(token, {"viewer", "camera"})) {
        event.directions.push_back(from ? DirectionWord::away : DirectionWord::toward);
      } else if (is_any(token, {"toward", "towards", "to", "into", "onto", "against"}) && i + 1 < tokens.size()) {
        if (find_direction(tokens[i + 1]) != DirectionWord::none || is_any(tokens[i + 1], {"viewer", "camera"}))
          continue;
        const std::string text = json.get<std::string>();
        const size_t at = text.find_last_of(' ');
        const std::string id = at == std::string::npos ? text : text.substr(at + 1);
        const std::vector<std::string> all = all_references(inventory_);
        const bool exact = std::find(all.begin(), all.end(), id) != all.end();
        std::vector<std::string> rest(tokens.begin() + i + 1, tokens.end());
        return way_to(resolve("direction", exact ? id : join(rest, " "), json), action);
      } else if (!is_filler(token)) {
        throw refused("direction", json, kDirectionForms);
      }
    }
    if (event.directions.empty()) throw refused("direction", json, kDirectionForms);
    return said_direction(event, geometry_);
  }

  // Unit vector from what moves to `goal`; to the right where the masks do not tell.
  Eigen::Vector3d way_to(const std::string& goal, const PlanAction& action) {
    const std::string& moved = action.source.empty() ? action.target : action.source;
    const auto a = geometry_.boxes.find(moved), b = geometry_.boxes.find(goal);
    if (a != geometry_.boxes.end() && b != geometry_.boxes.end()) {
      const Eigen::Vector3d way = b->second.center - a->second.center;
      if (way.norm() > kNoDirection * (a->second.half.norm() + b->second.half.norm())) return way.normalized();
    }
    note(fmt::format("the masks do not tell where {} is as seen from {}: to the right", goal, moved));
    return geometry_.right;
  }

  Eigen::Vector3d direction_of(const Json& json, const PlanAction& action) {
    Event event;
    Eigen::Vector3d said = Eigen::Vector3d::Zero();
    if (json.is_string()) said = spoken_direction(json, action, event);
    if (json.is_array()) said = vector3_from(json);
    if (json.is_array() && said.norm() <= kNoDirection) throw refused("direction", json, "a vector that is not zero");
    const Eigen::Vector3d own = own_direction(event, action.type, geometry_);
    const bool axis_is_free = action.type == ActionType::torque || action.type == ActionType::scale ||
                              action.type == ActionType::side_compress;
    if (own.norm() > 0 && (!axis_is_free || said.norm() <= kNoDirection || !event.directions.empty())) {
      if (!axis_is_free && said.norm() > kNoDirection && said.normalized().dot(own) < 1 - 1e-6)
        note("the direction of this action is fixed; the one given was left out");
      return own;
    }
    if (said.norm() > kNoDirection) return said.normalized();
    if (!action.source.empty()) return way_to(action.target, action);
    note("no direction given: to the right of the front view");
    return geometry_.right;
  }

  void set_interval(const Json& json, PlanAction& action) {
    const ActionLine& range = action_line(action.type);
    const double whole = run_.time.duration();
    const Json &start = json.at("start"), &end = json.at("end");
    action.start = start.is_null() ? std::min(range.start, 0.1 * whole) : start.get<double>();
    if (action.start >= whole) throw refused("start", start, fmt::format("a time before the run's end, {} s", whole));
    double length = range.end_fraction * whole - range.start;
    if (action.type == ActionType::translation && !action.source.empty())
      length = contact_time(action, geometry_, length);
    if (!end.is_null()) length = end.get<double>() - action.start;
    if (!end.is_null() && length <= 0) throw refused("end", end, fmt::format("a time after start, {} s", action.start));
    if (action.type == ActionType::impulse) {
      const double shortest = kImpulseSubsteps * run_.time.substep_dt;
      if (!end.is_null() && length > shortest) note(fmt::format("an impulse lasts {} s", shortest));
      length = end.is_null() ? shortest : std::min(length, shortest);
    }
    action.end = std::min(action.start + std::max(length, 0.0), whole);
    if (!end.is_null() && end.get<double>() > whole) note(fmt::format("cut at the run's end, {} s", whole));
  }

  const Inventory& inventory_;
  const SceneGeometry& geometry_;
  const RunSpecification& run_;
  Plan plan_;
  std::string where_;  // the action that is compiled
};

}  // namespace

Plan compile_proposal(const Json& proposal, const std::string& prompt, const Inventory& inventory,
                      const SceneGeometry& geometry, const RunSpecification& run) {
  return Compiler(inventory, geometry, run).compile(proposal, prompt);
}

}  // namespace physmas::plan
