#include "records/execution.h"

#include <cerrno>
#include <filesystem>

#include "records/json.h"

namespace physmas {
namespace {

Divergence divergence_from(const Json& json) {
  Divergence d;
  d.cause = json.at("cause").get<std::string>();
  d.row = json.at("row").get<std::string>();
  d.E = json.at("E").get<double>();
  d.wave_speed = json.at("wave_speed").get<double>();
  d.dx = json.at("dx").get<double>();
  d.dt = json.at("dt").get<double>();
  d.needed_dt = json.at("needed_dt").get<double>();
  d.frame = json.at("frame").get<int>();
  d.advice = json.at("advice").get<std::string>();
  return d;
}

Json divergence_json(const Divergence& d) {
  return {{"cause", d.cause},           {"row", d.row},     {"E", d.E},
          {"wave_speed", d.wave_speed}, {"dx", d.dx},       {"dt", d.dt},
          {"needed_dt", d.needed_dt},   {"frame", d.frame}, {"advice", d.advice}};
}

Json attempt_json(const Attempt& a) {
  return {{"rule", a.rule},      {"status", a.diverged ? "diverged" : "stable"},
          {"reason", a.reason},  {"frames", a.frames},
          {"substeps", a.steps}, {"allowed", a.allowed}};
}

Attempt attempt_from(const Json& json) {
  Attempt a;
  a.rule = json.at("rule").get<std::string>();
  a.diverged = json.at("status") == "diverged";
  a.reason = json.at("reason").get<std::string>();
  a.frames = json.at("frames").get<int>();
  a.steps = json.at("substeps").get<long>();
  a.allowed = json.at("allowed").get<long>();
  return a;
}

StartRecord start_from(const Json& json) {
  StartRecord start;
  start.supported_parts = json.at("supported_parts").get<int>();
  start.free_parts = json.at("free_parts").get<int>();
  start.supported_particles = json.at("supported_particles").get<long>();
  start.iterations = json.at("iterations").get<int>();
  start.corrections = json.at("corrections").get<int>();
  start.residual = json.at("residual").get<double>();
  start.largest_strain = json.at("largest_strain").get<double>();
  for (const Json& row : json.at("limited"))
    start.limited.emplace_back(row.at("row").get<std::string>(), row.at("particles").get<long>());
  return start;
}

Json start_json(const StartRecord& start) {
  Json json = {{"rule", "equilibrium"},          {"supported_parts", start.supported_parts},
               {"free_parts", start.free_parts}, {"supported_particles", start.supported_particles},
               {"iterations", start.iterations}, {"corrections", start.corrections},
               {"residual", start.residual},     {"largest_strain", start.largest_strain},
               {"limited", Json::array()}};
  for (const auto& [row, particles] : start.limited)
    json["limited"].push_back({{"row", row}, {"particles", particles}});
  return json;
}

std::vector<AchievedAction> achieved_from(const Json& document) {
  std::vector<AchievedAction> list;
  for (const Json& json : document.value("achieved", Json::array())) {
    AchievedAction a;
    a.type = action_from(json.at("type").get<std::string>());
    a.rows = json.at("rows").get<std::vector<std::string>>();
    a.quantity = json.at("quantity").get<std::string>();
    a.unit = json.at("unit").get<std::string>();
    a.requested = json.at("requested").get<double>();
    a.achieved = json.at("achieved").get<double>();
    a.share = json.at("share").get<double>();
    a.shortfall = json.value("shortfall", "");
    list.push_back(std::move(a));
  }
  return list;
}

Json achieved_json(const AchievedAction& a) {
  Json json = {{"type", action_name(a.type)}, {"rows", a.rows},         {"quantity", a.quantity}, {"unit", a.unit},
               {"requested", a.requested},    {"achieved", a.achieved}, {"share", a.share}};
  if (!a.shortfall.empty()) json["shortfall"] = a.shortfall;
  return json;
}

void stiff_from(const Json& document, ExecutionRecord& record) {
  if (!document.contains("stiff")) return;
  const Json& stiff = document.at("stiff");
  for (const Json& json : stiff.at("rows")) {
    StiffRowRecord row;
    row.key = json.at("row").get<std::string>();
    row.rigid = json.at("rigid").get<bool>();
    row.why = json.at("why").get<std::string>();
    row.limit = json.at("limit").get<double>();
    row.deflection = json.value("deflection", 0.0);
    row.bodies = json.at("bodies").get<std::vector<int>>();
    record.stiff_rows.push_back(std::move(row));
  }
  for (const Json& json : stiff.at("bodies")) {
    RigidBodyRecord body;
    body.rows = json.at("rows").get<std::vector<std::string>>();
    body.mass = json.at("mass").get<double>();
    body.impacts = json.at("impacts").get<long>();
    if (!json.at("restitution").is_null()) body.restitution = json.at("restitution").get<double>();
    body.largest_acceleration = json.at("largest_acceleration").get<double>();
    body.largest_jump = json.at("largest_jump").get<double>();
    body.error = json.at("error").get<double>();
    record.rigid_bodies.push_back(std::move(body));
  }
  const Json& windows = stiff.at("windows");
  record.impacts = {windows.at("count").get<long>(), windows.at("substeps").get<long>(),
                    windows.at("small_steps").get<long>()};
}

Json stiff_json(const ExecutionRecord& record) {
  Json stiff = {{"rows", Json::array()}, {"bodies", Json::array()}};
  for (const StiffRowRecord& row : record.stiff_rows) {
    Json json = {
        {"row", row.key}, {"rigid", row.rigid}, {"why", row.why}, {"limit", row.limit}, {"bodies", row.bodies}};
    if (row.deflection > 0) json["deflection"] = row.deflection;
    stiff["rows"].push_back(std::move(json));
  }
  for (const RigidBodyRecord& body : record.rigid_bodies) {
    stiff["bodies"].push_back({{"rows", body.rows},
                               {"mass", body.mass},
                               {"impacts", body.impacts},
                               {"restitution", body.restitution < 0 ? Json() : Json(body.restitution)},
                               {"largest_acceleration", body.largest_acceleration},
                               {"largest_jump", body.largest_jump},
                               {"error", body.error}});
  }
  stiff["windows"] = {{"count", record.impacts.count},
                      {"substeps", record.impacts.substeps},
                      {"small_steps", record.impacts.small_steps}};
  return stiff;
}

std::optional<Stillness> stillness_from(const Json& document) {
  const Json json = document.value("stillness", Json());
  if (json.is_null()) return std::nullopt;
  return Stillness{json.at("rows").get<std::vector<std::string>>(), json.at("drift").get<double>(),
                   json.at("share").get<double>()};
}

}  // namespace

ExecutionRecord load_execution(const std::string& path) {
  const Json document = load_record(path, "execution");
  ExecutionRecord record;
  record.candidate = document.at("candidate").get<std::string>();
  record.exit = document.at("process").at("exit").get<int>();
  record.signal = document.at("process").at("signal").get<int>();
  const Json& numerical = document.at("numerical");
  record.diverged = numerical.at("status") == "diverged";
  record.error_tokens = numerical.at("error_tokens").get<std::vector<std::string>>();
  record.reason = numerical.value("reason", "");
  if (numerical.contains("divergence")) record.divergence = divergence_from(numerical.at("divergence"));
  for (const Json& attempt : numerical.value("attempts", Json::array()))
    record.attempts.push_back(attempt_from(attempt));
  if (!numerical.at("first_bad_step").is_null()) record.first_bad_step = numerical.at("first_bad_step").get<long>();
  record.max_speed = numerical.at("max_speed").get<double>();
  if (!numerical.at("J_range").is_null()) {
    record.J_min = numerical.at("J_range")[0].get<double>();
    record.J_max = numerical.at("J_range")[1].get<double>();
  }
  record.mass = numerical.at("mass").get<double>();
  record.momentum_start = vector3_from(numerical.at("momentum").at("start"));
  record.momentum_end = vector3_from(numerical.at("momentum").at("end"));
  record.kinetic = numerical.at("energy").at("kinetic").get<std::vector<double>>();
  record.elastic = numerical.at("energy").at("elastic").get<std::vector<double>>();
  record.potential = numerical.at("energy").at("potential").get<std::vector<double>>();
  const Json& energy = numerical.at("energy");
  record.energy_measured = energy.value("measured", "frames");
  if (energy.contains("residual")) {
    record.energy_residual = energy.at("residual").at("joules").get<double>();
    record.energy_scale = energy.at("residual").at("scale").get<double>();
    record.largest_step_residual = energy.at("residual").value("largest_step", 0.0);
  }
  if (energy.contains("budget")) {
    for (const auto& [name, values] : energy.at("budget").items())
      record.energy_terms.emplace_back(name, values.get<std::vector<double>>());
  }
  record.particles_outside = numerical.at("particles_outside").get<long>();
  const Json& steps = document.at("steps");
  record.step_rule = steps.value("rule", "paper");
  record.substeps_per_frame = steps.at("per_frame").get<int>();
  record.steps = steps.at("total").get<long>();
  record.dt = steps.at("dt").get<double>();
  record.smallest_dt = steps.value("smallest_dt", record.dt);
  record.largest_dt = steps.value("largest_dt", record.dt);
  record.retries = steps.value("retries", 0L);
  record.discarded_steps = steps.value("discarded", 0L);
  record.frames = document.at("frames").get<int>();
  record.achieved = achieved_from(document);
  record.stillness = stillness_from(document);
  stiff_from(document, record);
  for (const Json& row : document.value("torn", Json::array()))
    record.torn.push_back({row.at("row").get<std::string>(), row.value("from", ""), row.at("share").get<double>()});
  record.particles = document.value("particles", 0L);
  record.grid = document.value("grid", Json::object());
  record.precision = document.value("precision", "float");
  record.deformation = document.value("deformation", "elastic");
  if (document.contains("start")) record.start = start_from(document.at("start"));
  record.omitted = omissions_from(document);
  record.runtime = document.at("runtime");
  return record;
}

std::string execution_path_of(const std::string& rollout) {
  return std::filesystem::path(rollout).replace_extension(".json").string();
}

ExecutionRecord load_execution_of(const std::string& rollout) {
  const std::string path = execution_path_of(rollout);
  std::error_code failure;
  if (!std::filesystem::exists(rollout, failure)) throw system_error(rollout, "cannot be read", ENOENT);
  ExecutionRecord record = load_execution(path);
  require_written_with(path, rollout);
  return record;
}

void save_execution(const std::string& path, const ExecutionRecord& record, const Provenance& provenance) {
  Json json;
  json["candidate"] = record.candidate;
  json["process"] = {{"exit", record.exit}, {"signal", record.signal}};
  Json& numerical = json["numerical"];
  numerical["status"] = record.diverged ? "diverged" : "stable";
  numerical["error_tokens"] = record.error_tokens;
  numerical["reason"] = record.reason;
  if (record.divergence) numerical["divergence"] = divergence_json(*record.divergence);
  if (!record.attempts.empty()) {
    numerical["attempts"] = Json::array();
    for (const Attempt& attempt : record.attempts) numerical["attempts"].push_back(attempt_json(attempt));
  }
  numerical["first_bad_step"] = record.first_bad_step < 0 ? Json() : Json(record.first_bad_step);
  numerical["max_speed"] = record.max_speed;
  const bool measured = record.energy_measured != "off";
  numerical["J_range"] = measured ? Json{record.J_min, record.J_max} : Json();
  numerical["mass"] = record.mass;
  numerical["momentum"] = {{"start", to_json(record.momentum_start)}, {"end", to_json(record.momentum_end)}};
  numerical["energy"] = {{"kinetic", record.kinetic}, {"elastic", record.elastic}, {"potential", record.potential}};
  Json& energy = numerical["energy"];
  energy["measured"] = record.energy_measured;
  if (measured) {
    energy["residual"] = {{"joules", record.energy_residual},
                          {"scale", record.energy_scale},
                          {"relative", record.energy_scale > 0 ? record.energy_residual / record.energy_scale : 0.0}};
  }
  if (!record.energy_terms.empty()) {
    energy["residual"]["largest_step"] = record.largest_step_residual;
    for (const auto& [name, values] : record.energy_terms) energy["budget"][name] = values;
  }
  numerical["particles_outside"] = record.particles_outside;
  json["steps"] = {
      {"rule", record.step_rule},  {"per_frame", record.substeps_per_frame}, {"total", record.steps},
      {"dt", record.dt},           {"smallest_dt", record.smallest_dt},      {"largest_dt", record.largest_dt},
      {"retries", record.retries}, {"discarded", record.discarded_steps}};
  json["frames"] = record.frames;
  json["achieved"] = Json::array();
  for (const AchievedAction& action : record.achieved) json["achieved"].push_back(achieved_json(action));
  json["stillness"] = Json();
  if (record.stillness) {
    json["stillness"] = {
        {"rows", record.stillness->rows}, {"drift", record.stillness->drift}, {"share", record.stillness->share}};
  }
  for (const TornRow& row : record.torn) {
    Json& torn = json["torn"].emplace_back(Json{{"row", row.key}});
    if (!row.from.empty()) torn["from"] = row.from;
    torn["share"] = row.share;
  }
  json["particles"] = record.particles;
  json["grid"] = record.grid;
  json["precision"] = record.precision;
  json["deformation"] = record.deformation;
  if (record.start) json["start"] = start_json(*record.start);
  if (!record.stiff_rows.empty()) json["stiff"] = stiff_json(record);
  json["omitted"] = to_json(record.omitted);
  json["runtime"] = record.runtime;
  save_record(path, "execution", provenance, json);
}

}  // namespace physmas
