#include "bundle/physgaussian.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "base/constants.h"
#include "base/file.h"
#include "bundle/foreign_json.h"
#include "bundle/physgaussian_boundaries.h"
#include "records/json.h"
#include "records/labels.h"
#include "records/run_specification.h"

namespace physmas::bundle {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadians = kPi / 180;
const Vector3d kCenter = Vector3d::Ones();  // where PhysGaussian puts the middle of the scene

// The axis name of a vector along an axis; empty for others.
std::string axis_name(const Vector3d& v) {
  for (const char* name : {"x", "y", "z", "-x", "-y", "-z"}) {
    if ((v.normalized() - axis_vector(name)).norm() < 1e-6) return name;
  }
  return "";
}

// The least distance of log E from a label's range, then of its density.
int nearest_label(Branch branch, double E, double rho) {
  int best = -1;
  std::pair<double, double> least;
  for (int i = 0; i < kLabelCount; ++i) {
    if (kLabels[i].branch != branch) continue;
    const std::pair<double, double> distance = {std::abs(std::log(E / kLabels[i].clip_E(E))),
                                                std::abs(std::log(rho / kLabels[i].rho))};
    if (best < 0 || distance < least) best = i, least = distance;
  }
  return best;
}

// Comments of // and /* */ outside of texts become spaces, so that lines and columns stay.
std::string without_comments(std::string text) {
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (quoted) {
      if (text[i] == '\\')
        ++i;
      else if (text[i] == '"')
        quoted = false;
      continue;
    }
    quoted = text[i] == '"';
    const bool line = text.compare(i, 2, "//") == 0, block = text.compare(i, 2, "/*") == 0;
    if (!line && !block) continue;
    const size_t end = std::min(block ? text.find("*/", i + 2) : text.find('\n', i), text.size());
    const size_t stop = block ? std::min(end + 2, text.size()) : end;
    for (; i < stop; ++i) {
      if (text[i] != '\n') text[i] = ' ';
    }
    --i;
  }
  return text;
}

class Configuration {
 public:
  Configuration(const Json& json, const std::string& file) : config_(json, file, "") {}

  PhysGaussianImport convert() {
    result_.run = {{"schema", "physmas/run/1"}};
    read_axes();
    read_grid_and_time();
    read_material();
    read_gravity();
    read_selection();
    read_filling();
    read_boundaries();
    name_the_rest();
    return std::move(result_);
  }

 private:
  bool take(const char* key) {
    taken_.insert(key);
    return config_.has(key);
  }
  double number(const char* key, double absent) { return take(key) ? config_.number(key) : absent; }
  double positive(const char* key, double absent) { return take(key) ? config_.positive(key) : absent; }
  void omit(const std::string& pointer, const std::string& why) { result_.not_mapped.push_back({pointer, why}); }

  // Scene to solver axes, and which scene axis is up.
  void read_axes() {
    const std::vector<double> degrees =
        take("rotation_degree") ? config_.numbers("rotation_degree") : std::vector<double>();
    const std::vector<double> axes = take("rotation_axis") ? config_.numbers("rotation_axis") : std::vector<double>();
    if (degrees.size() != axes.size())
      throw config_.error("rotation_axis", "as many axes as rotation_degree has angles");
    Matrix3d turned = Matrix3d::Identity();
    for (size_t i = 0; i < degrees.size(); ++i) {
      if (axes[i] != 0 && axes[i] != 1 && axes[i] != 2) throw config_.error("rotation_axis", "axes 0, 1 or 2");
      turned = Eigen::AngleAxisd(degrees[i] * kRadians, Vector3d::Unit(static_cast<int>(axes[i]))) * turned;
    }
    const Matrix3d rounded = turned.array().round();
    if ((turned - rounded).cwiseAbs().maxCoeff() < 1e-9)
      frame_.turned = rounded;
    else
      result_.turn = turned;
    const Vector3d up = take("mpm_space_vertical_upward_axis") ? config_.vector("mpm_space_vertical_upward_axis")
                                                               : Vector3d(Vector3d::UnitZ());
    result_.up = axis_name(frame_.direction(up));
    if (result_.up.empty()) {
      omit("/mpm_space_vertical_upward_axis", "not along an axis; up is taken as z");
      result_.up = "z";
    }
  }

  void read_grid_and_time() {
    const double cells = number("n_grid", 50), length = positive("grid_lim", 2);
    if (!(cells >= 16 && cells <= 512) || cells != std::floor(cells)) throw config_.error("n_grid", "16 to 512 cells");
    result_.run["grid"] = {{"n", static_cast<int>(cells)}, {"length", length}};
    result_.run["placement"] = {{"extent", positive("scale", 1)}, {"center", to_json(kCenter)}, {"up", result_.up}};
    const double dt = positive("substep_dt", 1e-4), frame_dt = positive("frame_dt", 1e-2);
    const double frames = number("frame_num", 100);
    if (!(frames >= 1 && frames < 10000)) throw config_.error("frame_num", "1 to 9999 frames");
    frame_.duration = frames * frame_dt;
    const double least = std::min(5e-5, dt);
    // PhysGaussian's frames do not count the rest frame.
    result_.run["time"] = {
        {"frames", static_cast<int>(frames) + 1},
        {"frame_dt", frame_dt},
        {"substep_dt", dt},
        {"min_substep_dt", least},
        {"max_substeps", std::max(800, static_cast<int>(std::ceil(std::min(frame_dt / least, 1e6))))}};
  }

  void read_material() {
    const std::string name = take("material") ? config_.text("material") : "jelly";
    const std::optional<Branch> branch = find_branch(name);
    if (!branch) throw config_.error("material", "jelly, metal, sand, foam, snow or plasticine");
    result_.E = positive("E", 1e5);
    result_.nu = number("nu", 0.4);
    if (!(result_.nu >= 0 && result_.nu < 0.5)) throw config_.error("nu", "0 to below 0.5");
    const double rho = positive("density", 200);
    result_.label = nearest_label(*branch, result_.E, rho);
    const LabelPrior& label = kLabels[result_.label];
    if (rho != label.rho) {
      omit("/density", fmt::format("densities follow the material's label: {} has {} kg/m^3", label.name, label.rho));
    }
    if (label.clip_E(result_.E) != result_.E || label.clip_nu(result_.nu) != result_.nu) {
      omit("/E", fmt::format("E {:g} and nu {:g} are clipped to the range of {}", result_.E, result_.nu, label.name));
    }
    Json& profile = result_.run["profile"] = Json::object();
    if (take("friction_angle")) profile["sand_friction_angle"] = config_.positive("friction_angle");
    const bool foam = *branch == Branch::foam, plasticine = *branch == Branch::plasticine;
    if (foam && take("yield_stress")) profile["foam_yield"] = config_.positive("yield_stress");
    if (foam && take("plastic_viscosity")) profile["foam_viscosity"] = config_.positive("plastic_viscosity");
    if (plasticine && take("yield_stress")) profile["plasticine_yield"] = config_.positive("yield_stress");
  }

  void read_gravity() {
    if (!take("g")) return;
    const std::vector<double> g = config_.numbers("g");
    if (g.size() == 1) {
      result_.run["gravity"] = -std::abs(g[0]);
    } else {
      result_.run["gravity"] = to_json(frame_.direction(config_.vector("g")));
    }
  }

  void read_selection() {
    result_.selection.opacity_threshold = number("opacity_threshold", 0.02);
    if (!take("sim_area")) return;
    const std::vector<double> area = config_.numbers("sim_area");
    if (area.size() != 6) throw config_.error("sim_area", "six numbers: x0 x1 y0 y1 z0 z1");
    for (int axis = 0; axis < 3; ++axis) {
      if (!(area[2 * axis] < area[2 * axis + 1])) throw config_.error("sim_area", "lower ends below upper ends");
    }
    Eigen::AlignedBox3d box;
    box.extend(frame_.turned.transpose() * Vector3d(area[0], area[2], area[4]));
    box.extend(frame_.turned.transpose() * Vector3d(area[1], area[3], area[5]));
    result_.selection.crop = box;
    result_.selection.crop_axes = result_.turn;
    omit("/sim_area", "taken as a crop: Gaussians outside it are not drawn either");
  }

  void read_filling() {
    Json& particles = result_.run["particles"] = Json::object();
    particles["fill"] = take("particle_filling");
    if (!config_.has("particle_filling")) return;
    const ForeignObject filling(config_.json().at("particle_filling"), config_.file(), "/particle_filling");
    for (const auto& [key, value] : filling.json().items()) {
      // PhysGaussian spells it the first way.
      if (key == "max_partciels_per_cell" || key == "max_particles_per_cell") {
        const double count = filling.number(key);
        if (!(count >= 1 && count <= 64)) throw filling.error(key, "1 to 64");
        particles["per_cell"] = static_cast<int>(count);
      } else if (key == "max_particles_num") {
        const double count = filling.number(key);
        if (!(count >= 1 && count <= 1e7)) throw filling.error(key, "1 to 10000000");
        particles["max"] = static_cast<int>(count);
      } else {
        omit("/particle_filling/" + key, "filling follows the paper's rule here (docs/method-lifting.md)");
      }
    }
  }

  void read_boundaries() {
    take("boundary_conditions");
    PhysGaussianBoundaries boundaries = physgaussian_boundaries(config_, frame_);
    result_.run["colliders"] = std::move(boundaries.colliders);
    for (Omission& boundary : boundaries.not_mapped) result_.not_mapped.push_back(std::move(boundary));
  }

  void name_the_rest() {
    static const std::set<std::string> kCameras = {"mpm_space_viewpoint_center",
                                                   "default_camera_index",
                                                   "show_hint",
                                                   "init_azimuthm",
                                                   "init_elevation",
                                                   "init_radius",
                                                   "move_camera",
                                                   "delta_a",
                                                   "delta_e",
                                                   "delta_r"};
    static const std::set<std::string> kSolver = {
        "grid_v_damping_scale", "rpic_damping",     "pic_damping", "hardening", "xi", "softening",
        "yield_stress",         "plastic_viscosity"};
    for (const auto& [key, value] : config_.json().items()) {
      if (taken_.count(key)) continue;
      if (kCameras.count(key)) {
        omit("/" + key, "cameras are set with --azimuth and --elevation, or --views and --cameras");
      } else if (key == "additional_material_params") {
        omit("/" + key, "materials belong to parts: name them in an inventory");
      } else if (kSolver.count(key)) {
        omit("/" + key, "the solver has no such setting for this material");
      } else {
        omit("/" + one_line(key, 60), "an unknown field");
      }
    }
  }

  ForeignObject config_;
  PhysGaussianImport result_;
  std::set<std::string> taken_;
  PhysGaussianFrame frame_;
};

}  // namespace

PhysGaussianImport physgaussian_from(const Json& json, const std::string& file) {
  PhysGaussianImport import = Configuration(json, file).convert();
  validate_record(import.run, "run", file);
  run_specification_from(import.run, file, "");  // what a schema cannot check
  return import;
}

PhysGaussianImport load_physgaussian(const std::string& path) {
  return physgaussian_from(parse_json(without_comments(read_file(path)), path), path);
}

Json material_hints(const PhysGaussianImport& import, const std::vector<std::string>& keys) {
  // As certain as an authored value can be: a tenth of a decade, a hundredth of nu.
  const Json crop = {{"E", import.E},
                     {"E_uncertainty", 0.1},
                     {"nu", import.nu},
                     {"nu_uncertainty", 0.01},
                     {"evidence", {{kLabels[import.label].name, 1}}}};
  Json record = {{"rows", Json::array()}};
  for (const std::string& key : keys) record["rows"].push_back({{"key", key}, {"crops", Json::array({crop})}});
  record["whole_object"] = {{"label", kLabels[import.label].name}, {"crops", Json::array({crop})}};
  return record;
}

}  // namespace physmas::bundle
