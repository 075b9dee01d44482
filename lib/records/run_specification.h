// The run specification: everything about a run that neither agent may change. Every field has a default. What a file
// may say is listed in run_fields.h.
#ifndef PHYSMAS_RECORDS_RUN_SPECIFICATION_H
#define PHYSMAS_RECORDS_RUN_SPECIFICATION_H

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "records/json_fwd.h"

namespace physmas {

// A unit vector along a scene axis, from "x", "-y", ... (the names that `--up` takes).
Eigen::Vector3d axis_vector(const std::string& name);

struct RunSpecification {
  struct Grid {
    int n = 100;        // cells per axis
    double length = 2;  // edge of the solver cube
    double dx() const { return length / n; }
  } grid;

  // Where N(x) = s x + d puts the scene: longest side `extent`, centre of the bounding box at `center`.
  struct Placement {
    double extent = 1;
    Eigen::Vector3d center = {1, 1, 1};  // solver space
    std::string up = "z";                // scene axis, the same in solver space
    Eigen::Vector3d up_vector() const { return axis_vector(up); }
  } placement;

  struct Time {
    int frames = 50;                     // T, frame 0 is the rest frame
    double frame_dt = 0.04;              // s
    double substep_dt = 2e-4;            // s
    double min_substep_dt = 5e-5;        // s
    int max_substeps = 800;              // per output frame
    std::string rule = "paper";          // paper | cfl: what pm-simulate follows
    std::string on_divergence = "stop";  // stop | cfl: a diverged candidate is simulated once more with the cfl rule
    std::string stiff = "off";           // off | rigid | auto: what becomes of rows too stiff for the substep
    int retry_substeps = 40000;          // that this may take; the paper's rule: at most 800 for each of 50 frames
    // rest: nothing is stressed at first, F = I, as in the paper. equilibrium: what stands on something carries its
    // weight from the first substep on, in its captured shape.
    enum class Start { rest, equilibrium } start = Start::rest;
    double duration() const { return frame_dt * (frames - 1); }
  } time;

  Eigen::Vector3d gravity = {0, 0, -9.8};  // m/s^2, solver space; resolved from `up` when the file gives one number

  struct Collider {
    enum class Type { plane, box, sphere } type = Type::plane;
    enum class Mode { sticky, slip, separate } mode = Mode::separate;
    Eigen::Vector3d point = {0, 0, 0};                 // plane: a point on it; sphere: centre; solver space
    Eigen::Vector3d normal = {0, 0, 1};                // plane: unit, towards the free side
    Eigen::Vector3d min = {0, 0, 0}, max = {0, 0, 0};  // box
    double radius = 0;                                 // sphere
    double friction = 0.4;                             // Coulomb coefficient
  };
  std::vector<Collider> colliders;

  // Between objects. stick: one velocity field for everything, as the paper has it; what touches stays together.
  // separate: a field per object; they push, rub and part.
  struct Contact {
    enum class Objects { stick, separate };
    std::optional<Objects> objects;  // stick
    std::optional<double> friction;  // Coulomb coefficient; 0.4
    bool separates() const { return objects.value_or(Objects::stick) == Objects::separate; }
    double friction_between() const { return friction.value_or(0.4); }
  } contact;

  int walls = 3;  // cells between the domain's faces and its walls

  struct ParticleBudget {
    int max = 200000;
    int per_cell = 8;
    bool fill = true;
    // How many of so many Gaussians are particles: all, or, where that is more than the budget, half of it, so that
    // interiors can be filled. The others are carried (state.h).
    size_t simulated(size_t gaussians) const {
      return gaussians <= static_cast<size_t>(max) ? gaussians : static_cast<size_t>((max + 1) / 2);
    }
  } particles;

  struct Segmentation {
    bool grabcut = true;  // the built-in segmenter refines the boundaries between parts
  } segmentation;

  struct Lifting {
    // none: a Gaussian takes evidence from every view that it projects into, seen or not, as the paper writes it.
    // depth: only from views in which nothing lies in front of it.
    enum class Occlusion { none, depth } occlusion = Occlusion::none;
    // join: small pieces of a row that hang apart from it are given to what they touch.
    enum class Islands { keep, join } islands = Islands::join;
    // Cells within which a particle takes the numbers of the nearest sample of a material field. Not said: as far as
    // the samples reach (lift/material_samples.h).
    std::optional<double> field_reach;
  } lifting;

  // Fixed constants of the six profiles, solver-space pascals (readings, "Constitutive branches and stepping").
  struct Profile {
    double foam_yield = 2e3, foam_viscosity = 10;
    double plasticine_yield = 2e3, plasticine_softening = 200, plasticine_residual = 0.1;
    double sand_friction_angle = 30;  // degrees
    double alpha = 0.16;
    double sand_k = 0, snow_k = 1000, plasticine_k = 5000;
  } profile;

  struct Projection {
    bool rigid = false;  // structure projection turns with the row; false: the paper's, which un-rotates a support
  } projection;

  // How actions act beyond the paper's table (docs/actions.md).
  struct Controls {
    bool literal_release =
        false;                 // what was pressed, twisted or stretched is let go in one substep; false: as by a hand
    bool blend_stiff = false;  // a twist is a bounded force also on rows that it cannot move; false: they are turned
  } controls;

  struct Transport {
    bool total = false;  // Gaussians are carried by the total deformation; false: by the elastic one, as the paper does
  } transport;

  struct Screening {
    int initial = 6;
    int rounds = 3;
    int repairs = 3;
    double tau = 0.72;
    bool excuse_rotation = true;  // what turned is not flattened; false: image boxes alone, the paper's letter
    double achieved_min = 0;      // 0..1: an action that met less of its request is a failed gate; 0: off
    // 0..1: as much must stand still of what nothing moves. 0: off; not said: 0.5 where the prompt asks for no motion.
    std::optional<double> stillness_min;
    double dark_luminance = 0.08;  // Rec. 709 luminance of 8-bit sRGB values, 0..1
    // w of Eq. supp-critic: video, part confidence, diversity, role, base, density, solver.
    std::array<double, 7> weights = {1, 0.27, 0.10, 0.25, 0.15, 0.08, 0.15};
  } screening;

  // Studies (paper, "Ablation Study"): what is taken out of the method.
  struct Ablation {
    bool object_part_state = true;     // false: every object is one part with one material
    bool structure_projection = true;  // false: no candidate has projection weights or retention
    bool part_materials = true;        // false: every object has one material, and no controls of parts
  } ablation;

  struct Render {
    int width = 800, height = 800;
    Eigen::Vector3d background = {1, 1, 1};  // sRGB
    int sh_degree = 3;
    // What follows is about the video alone: measurements are those of the Gaussians in the scene's first output
    // camera. fixed: the scene's output cameras; fit: moved back as far as it takes to see all motion; orbit: turning
    // about the scene as well.
    enum class CameraMode { fixed, fit, orbit };
    std::optional<CameraMode> camera;  // fixed
    enum class Floor { none, shadow };
    std::optional<Floor> floor;  // none
    std::optional<bool> agents;  // false; true: a sign where an action acts
    CameraMode camera_mode() const { return camera.value_or(CameraMode::fixed); }
    bool has_floor() const { return floor.value_or(Floor::none) == Floor::shadow; }
    bool shows_agents() const { return agents.value_or(false); }
  } render;
};

// Of Projection::rigid, false and true.
inline constexpr std::array<const char*, 2> kProjectionModes = {"literal", "rigid"};
// Of Controls::literal_release and ::blend_stiff, false and true.
inline constexpr std::array<const char*, 2> kReleases = {"hand", "literal"};
inline constexpr std::array<const char*, 2> kStiffDrives = {"enforced", "blended"};

// Reads a `run` object that its schema already accepted; absent fields keep their defaults. Checks what a schema
// cannot (a collider's fields fit its type, normals are not zero, placement fits the cube, steps are consistent).
// file, pointer: where `json` stands, for messages.
RunSpecification run_specification_from(const Json& json, const std::string& file, const std::string& pointer);

// The complete specification, every default written out.
Json to_json(const RunSpecification& run);
// Of that, what the slices of `stages` hold (run_fields.h).
Json to_json(const RunSpecification& run, unsigned stages);

}  // namespace physmas

#endif
