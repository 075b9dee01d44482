#include "candidate/build.h"

#include <fmt/format.h>

#include <algorithm>

#include "candidate/one_material.h"
#include "candidate/schedule.h"
#include "candidate/timestep.h"
#include "candidate/transforms.h"

namespace physmas::candidate {
namespace {

Candidate complete(const Context& context, Configuration configuration, const std::string& plan_file) {
  Candidate candidate;
  candidate.timestep = step_size(configuration.rows, context.evidence.whole_object, context.run.time,
                                 context.run.grid.length / context.run.grid.n, context.state);
  candidate.omitted = context.inactive;
  candidate.schedule = compile_schedule(context, configuration, candidate.timestep, plan_file, candidate.omitted);
  candidate.rows = std::move(configuration.rows);
  candidate.projection = std::move(configuration.projection);
  candidate.retention = std::move(configuration.retention);
  return candidate;
}

// The studies without structure projection, or without materials of parts: U_aux is empty.
bool has_controls(const Context& context) {
  return context.run.ablation.structure_projection && context.run.ablation.part_materials;
}

void take_out_controls(const Context& context, Configuration& configuration) {
  if (has_controls(context)) return;
  if (!context.run.ablation.part_materials) bound_stiffness(configuration);
  configuration.projection.clear();
  configuration.retention.clear();
}

// Why a configuration is against the study that the run is; empty when it is not.
std::string against_study(const Context& context, const Configuration& configuration) {
  const bool fits = context.run.ablation.part_materials || has_one_material(context.inventory, configuration);
  return fits ? "" : "it gives an object two materials, and ablation.part_materials is false";
}

// The first candidate with these rows and controls, or null.
template <class Candidates>
auto find_equal(Candidates& candidates, const Configuration& configuration) -> decltype(&candidates.front()) {
  for (auto& candidate : candidates) {
    if (configuration_of(candidate) == configuration) return &candidate;
  }
  return nullptr;
}

}  // namespace

Round build_initial(const Context& context, const std::string& plan_file) {
  Round round;
  if (!has_controls(context)) {
    const char* study = context.run.ablation.structure_projection ? "part_materials" : "structure_projection";
    round.omitted.push_back({"projection weights and retention", fmt::format("ablation.{} is false", study)});
  }
  for (const char* name : kInitialTransforms) {
    std::string why;
    std::optional<Configuration> configuration = transform(context, name, why);
    if (configuration) {
      keep_stated(context, *configuration);
      take_out_controls(context, *configuration);
      why = against_study(context, *configuration);
    }
    if (!configuration || !why.empty()) {
      round.omitted.push_back({name, why});
      continue;
    }
    if (Candidate* equal = find_equal(round.candidates, *configuration)) {
      equal->omitted.push_back({name, "its rows and controls equal those of this candidate"});
      round.omitted.push_back({name, "its rows and controls equal those of " + equal->id});
      continue;
    }
    if (static_cast<int>(round.candidates.size()) == context.run.screening.initial) {
      round.omitted.push_back(
          {name, fmt::format("the first {} applicable candidates are retained", context.run.screening.initial)});
      continue;
    }
    Candidate candidate = complete(context, std::move(*configuration), plan_file);
    candidate.id = candidate.transform = name;
    candidate.order = static_cast<int>(round.candidates.size());
    candidate.base_confidence = context.mean_part_confidence;
    round.candidates.push_back(std::move(candidate));
  }
  return round;
}

Round build_repairs(const Context& context, const ScreenRecord& screen, const std::vector<Candidate>& seen,
                    const std::string& plan_file) {
  Round round;
  round.round = screen.round + 1;
  if (screen.decision != "repair") {
    round.omitted.push_back({"repairs", fmt::format("round {} ended with \"{}\"", screen.round, screen.decision)});
    return round;
  }
  const auto base =
      std::find_if(seen.begin(), seen.end(), [&](const Candidate& c) { return c.id == screen.repair_base; });
  if (base == seen.end()) throw internal_error("the repair base is not among the seen candidates");
  for (const char* name : kRepairNames) {
    const auto& routes = screen.repair_routes;
    if (std::find(routes.begin(), routes.end(), name) == routes.end()) continue;
    const std::string id = base->id + "-" + name;
    const auto has_id = [&](const Candidate& c) { return c.id == id; };
    if (std::any_of(seen.begin(), seen.end(), has_id)) {
      round.omitted.push_back({id, "it was evaluated before"});
      continue;
    }
    Configuration configuration = repair(context, name, *base);
    keep_stated(context, configuration);
    take_out_controls(context, configuration);
    const std::string why = against_study(context, configuration);
    if (!why.empty()) {
      round.omitted.push_back({id, why});
      continue;
    }
    const Candidate* equal = find_equal(seen, configuration);
    if (equal == nullptr) equal = find_equal(round.candidates, configuration);
    if (equal != nullptr) {
      round.omitted.push_back({id, "its rows and controls equal those of " + equal->id});
      continue;
    }
    if (static_cast<int>(round.candidates.size()) == context.run.screening.repairs) {
      round.omitted.push_back({id, fmt::format("at most {} repairs in a round", context.run.screening.repairs)});
      continue;
    }
    Candidate candidate = complete(context, std::move(configuration), plan_file);
    candidate.id = id;
    candidate.transform = name;
    candidate.parent = base->id;
    candidate.order = static_cast<int>(seen.size() + round.candidates.size());
    candidate.round = round.round;
    candidate.base_confidence = base->base_confidence;
    round.candidates.push_back(std::move(candidate));
  }
  return round;
}

}  // namespace physmas::candidate
