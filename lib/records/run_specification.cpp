#include "records/run_specification.h"

#include <array>
#include <cmath>

#include "records/json_fields.h"
#include "records/names.h"

namespace physmas {
namespace {

using Collider = RunSpecification::Collider;

constexpr std::array<const char*, 3> kColliderTypes = {"plane", "box", "sphere"};
constexpr std::array<const char*, 2> kOcclusions = {"none", "depth"};
constexpr std::array<const char*, 3> kColliderModes = {"sticky", "slip", "separate"};

Collider collider_from(const Json& json, const std::string& file, const std::string& pointer) {
  Collider c;
  c.type = static_cast<Collider::Type>(index_of(kColliderTypes, json.at("type").get<std::string>()));
  if (json.contains("mode")) {
    c.mode = static_cast<Collider::Mode>(index_of(kColliderModes, json.at("mode").get<std::string>()));
  }
  read_if_present(json, "friction", c.friction);
  static const std::array<std::vector<const char*>, 3> kFields = {
      {{"point", "normal"}, {"min", "max"}, {"center", "radius"}}};
  for (size_t type = 0; type < kFields.size(); ++type) {
    for (const char* field : kFields[type]) {
      if (json.contains(field) != (static_cast<int>(type) == static_cast<int>(c.type))) {
        throw invalid_field(
            file, pointer, json,
            std::string("a ") + kColliderTypes[static_cast<int>(c.type)] + " with exactly its own fields",
            "plane: point, normal; box: min, max; sphere: center, radius");
      }
    }
  }
  read_if_present(json, "point", c.point);
  read_if_present(json, "center", c.point);
  read_if_present(json, "normal", c.normal);
  read_if_present(json, "min", c.min);
  read_if_present(json, "max", c.max);
  read_if_present(json, "radius", c.radius);
  if (c.type == Collider::Type::plane) {
    if (!(c.normal.norm() > 1e-9))
      throw invalid_field(file, pointer + "/normal", json.at("normal"), "a vector that is not zero");
    c.normal.normalize();
  }
  if (c.type == Collider::Type::box && !(c.max.array() > c.min.array()).all()) {
    throw invalid_field(file, pointer + "/max", json.at("max"), "a corner above /min on every axis");
  }
  return c;
}

}  // namespace

Eigen::Vector3d axis_vector(const std::string& name) {
  const bool negative = !name.empty() && name[0] == '-';
  const char letter = name.size() == (negative ? 2u : 1u) ? name.back() : '?';
  if (letter < 'x' || letter > 'z')
    throw Error(ExitCode::usage, "found axis \"" + name + "\", expected x, y, z, -x, -y or -z");
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[letter - 'x'] = negative ? -1 : 1;
  return axis;
}

RunSpecification run_specification_from(const Json& json, const std::string& file, const std::string& pointer) {
  RunSpecification run;
  const Json empty = Json::object();
  const auto section = [&](const char* name) -> const Json& { return json.contains(name) ? json.at(name) : empty; };

  const Json& grid = section("grid");
  read_if_present(grid, "n", run.grid.n);
  read_if_present(grid, "length", run.grid.length);

  const Json& placement = section("placement");
  run.placement.extent = 0.5 * run.grid.length;
  run.placement.center.setConstant(0.5 * run.grid.length);
  read_if_present(placement, "extent", run.placement.extent);
  read_if_present(placement, "center", run.placement.center);
  read_if_present(placement, "up", run.placement.up);

  const Json& time = section("time");
  read_if_present(time, "frames", run.time.frames);
  read_if_present(time, "frame_dt", run.time.frame_dt);
  read_if_present(time, "substep_dt", run.time.substep_dt);
  read_if_present(time, "min_substep_dt", run.time.min_substep_dt);
  read_if_present(time, "max_substeps", run.time.max_substeps);
  read_if_present(time, "rule", run.time.rule);
  if (run.time.substep_dt > run.time.frame_dt) {
    throw invalid_field(file, pointer + "/time/substep_dt", run.time.substep_dt, "at most frame_dt");
  }
  if (run.time.min_substep_dt > run.time.substep_dt) {
    throw invalid_field(file, pointer + "/time/min_substep_dt", run.time.min_substep_dt, "at most substep_dt");
  }

  run.gravity = -9.8 * run.placement.up_vector();
  if (json.contains("gravity")) {
    const Json& gravity = json.at("gravity");
    run.gravity = gravity.is_number() ? Eigen::Vector3d(gravity.get<double>() * run.placement.up_vector())
                                      : vector3_from(gravity);
  }

  const Json& colliders = json.contains("colliders") ? json.at("colliders") : empty;
  for (size_t i = 0; i < colliders.size(); ++i) {
    run.colliders.push_back(collider_from(colliders[i], file, pointer + "/colliders/" + std::to_string(i)));
  }
  read_if_present(json, "walls", run.walls);

  const Json& particles = section("particles");
  read_if_present(particles, "max", run.particles.max);
  read_if_present(particles, "per_cell", run.particles.per_cell);
  read_if_present(particles, "fill", run.particles.fill);

  read_if_present(section("segmentation"), "grabcut", run.segmentation.grabcut);
  if (section("lifting").contains("occlusion")) {
    run.lifting.occlusion = static_cast<RunSpecification::Lifting::Occlusion>(
        index_of(kOcclusions, json.at("lifting").at("occlusion").get<std::string>()));
  }

  const Json& profile = section("profile");
  read_if_present(profile, "foam_yield", run.profile.foam_yield);
  read_if_present(profile, "foam_viscosity", run.profile.foam_viscosity);
  read_if_present(profile, "plasticine_yield", run.profile.plasticine_yield);
  read_if_present(profile, "plasticine_softening", run.profile.plasticine_softening);
  read_if_present(profile, "plasticine_residual", run.profile.plasticine_residual);
  read_if_present(profile, "sand_friction_angle", run.profile.sand_friction_angle);
  read_if_present(profile, "alpha", run.profile.alpha);
  read_if_present(profile, "sand_k", run.profile.sand_k);
  read_if_present(profile, "snow_k", run.profile.snow_k);
  read_if_present(profile, "plasticine_k", run.profile.plasticine_k);

  run.projection.rigid = section("projection").value("mode", "literal") == "rigid";
  run.transport.total = section("transport").value("deformation", "elastic") == "total";

  const Json& screening = section("screening");
  read_if_present(screening, "initial", run.screening.initial);
  read_if_present(screening, "rounds", run.screening.rounds);
  read_if_present(screening, "repairs", run.screening.repairs);
  read_if_present(screening, "tau", run.screening.tau);
  read_if_present(screening, "dark_luminance", run.screening.dark_luminance);
  read_if_present(screening, "weights", run.screening.weights);

  const Json& ablation = section("ablation");
  read_if_present(ablation, "object_part_state", run.ablation.object_part_state);
  read_if_present(ablation, "structure_projection", run.ablation.structure_projection);
  read_if_present(ablation, "part_materials", run.ablation.part_materials);

  const Json& render = section("render");
  read_if_present(render, "width", run.render.width);
  read_if_present(render, "height", run.render.height);
  read_if_present(render, "background", run.render.background);
  read_if_present(render, "sh_degree", run.render.sh_degree);

  const double wall = run.walls * run.grid.dx();
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * run.placement.extent);
  if (((run.placement.center - half).array() < wall).any() ||
      ((run.placement.center + half).array() > run.grid.length - wall).any()) {
    throw invalid_field(file, pointer + "/placement", to_json(run).at("placement"),
                        "a cube of edge `extent` at `center` inside the walls of the solver domain",
                        "make extent smaller or move center towards the middle");
  }
  return run;
}

Json to_json(const RunSpecification& run) {
  Json json;
  json["grid"] = {{"n", run.grid.n}, {"length", run.grid.length}};
  json["placement"] = {
      {"extent", run.placement.extent}, {"center", to_json(run.placement.center)}, {"up", run.placement.up}};
  json["time"] = {{"frames", run.time.frames},
                  {"frame_dt", run.time.frame_dt},
                  {"substep_dt", run.time.substep_dt},
                  {"min_substep_dt", run.time.min_substep_dt},
                  {"max_substeps", run.time.max_substeps},
                  {"rule", run.time.rule}};
  json["gravity"] = to_json(run.gravity);
  json["colliders"] = Json::array();
  for (const Collider& c : run.colliders) {
    Json entry;
    entry["type"] = kColliderTypes[static_cast<int>(c.type)];
    switch (c.type) {
      case Collider::Type::plane:
        entry["point"] = to_json(c.point);
        entry["normal"] = to_json(c.normal);
        break;
      case Collider::Type::box:
        entry["min"] = to_json(c.min);
        entry["max"] = to_json(c.max);
        break;
      case Collider::Type::sphere:
        entry["center"] = to_json(c.point);
        entry["radius"] = c.radius;
        break;
    }
    entry["mode"] = kColliderModes[static_cast<int>(c.mode)];
    entry["friction"] = c.friction;
    json["colliders"].push_back(entry);
  }
  json["walls"] = run.walls;
  json["particles"] = {{"max", run.particles.max}, {"per_cell", run.particles.per_cell}, {"fill", run.particles.fill}};
  json["segmentation"] = {{"grabcut", run.segmentation.grabcut}};
  json["lifting"] = {{"occlusion", kOcclusions[static_cast<int>(run.lifting.occlusion)]}};
  json["profile"] = {{"foam_yield", run.profile.foam_yield},
                     {"foam_viscosity", run.profile.foam_viscosity},
                     {"plasticine_yield", run.profile.plasticine_yield},
                     {"plasticine_softening", run.profile.plasticine_softening},
                     {"plasticine_residual", run.profile.plasticine_residual},
                     {"sand_friction_angle", run.profile.sand_friction_angle},
                     {"alpha", run.profile.alpha},
                     {"sand_k", run.profile.sand_k},
                     {"snow_k", run.profile.snow_k},
                     {"plasticine_k", run.profile.plasticine_k}};
  json["projection"] = {{"mode", run.projection.rigid ? "rigid" : "literal"}};
  json["transport"] = {{"deformation", run.transport.total ? "total" : "elastic"}};
  json["screening"] = {{"initial", run.screening.initial},
                       {"rounds", run.screening.rounds},
                       {"repairs", run.screening.repairs},
                       {"tau", run.screening.tau},
                       {"dark_luminance", run.screening.dark_luminance},
                       {"weights", run.screening.weights}};
  json["ablation"] = {{"object_part_state", run.ablation.object_part_state},
                      {"structure_projection", run.ablation.structure_projection},
                      {"part_materials", run.ablation.part_materials}};
  json["render"] = {{"width", run.render.width},
                    {"height", run.render.height},
                    {"background", to_json(run.render.background)},
                    {"sh_degree", run.render.sh_degree}};
  return json;
}

}  // namespace physmas
