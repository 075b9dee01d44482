// The fields of the run specification, each once: its name, its place, what its schema allows, what it is, and the
// stages whose slices hold it. Reader, writer, slices and schemas/run.json (`make schemas`) stem from this list.
#ifndef PHYSMAS_RECORDS_RUN_FIELDS_H
#define PHYSMAS_RECORDS_RUN_FIELDS_H

#include "records/fields.h"
#include "records/run_specification.h"

namespace physmas {

// The stages that have a slice (slices.h).
enum Stage : unsigned {
  kGround = 1,
  kLift = 2,
  kMaterial = 4,
  kCandidates = 8,
  kSimulate = 16,
  kRender = 32,
  kScreen = 64,
  kEveryStage = 127
};

inline constexpr std::array<const char*, 3> kColliderTypes = {"plane", "box", "sphere"};
inline constexpr std::array<const char*, 3> kColliderModes = {"sticky", "slip", "separate"};
inline constexpr std::array<const char*, 2> kTimeRules = {"paper", "cfl"};
inline constexpr std::array<const char*, 2> kOnDivergence = {"stop", "cfl"};
inline constexpr std::array<const char*, 3> kStiffRules = {"off", "rigid", "auto"};
inline constexpr std::array<const char*, 2> kStarts = {"rest", "equilibrium"};
inline constexpr std::array<const char*, 2> kContacts = {"stick", "separate"};
inline constexpr std::array<const char*, 2> kIslands = {"keep", "join"};
inline constexpr std::array<const char*, 2> kOcclusions = {"none", "depth"};
inline constexpr std::array<const char*, 3> kCameraModes = {"fixed", "fit", "orbit"};
inline constexpr std::array<const char*, 2> kFloors = {"none", "shadow"};
inline constexpr std::array<const char*, 2> kDeformations = {"elastic", "total"};

// A vector for which a file may give one number, along `up`.
template <class Vector>
struct AlongUp {
  Vector& value;
  Eigen::Vector3d up;
};
template <class Vector>
AlongUp<Vector> along_up(Vector& value, const Eigen::Vector3d& up) {
  return {value, up};
}

// every_type: the fields of all types of colliders, and not only those of `c`.
template <class Collider, class Visitor>
void visit_fields(Collider& c, Visitor& visitor, bool every_type) {
  using Type = RunSpecification::Collider::Type;
  visitor.field("type", choice(c.type, kColliderTypes), {}, "");
  if (every_type || c.type == Type::plane) {
    visitor.field("point", c.point, kVec3, "plane: a point on it, solver space");
    visitor.field("normal", c.normal, kVec3, "plane: towards the free side");
  }
  if (every_type || c.type == Type::box) {
    visitor.field("min", c.min, kVec3, "box: lower corner");
    visitor.field("max", c.max, kVec3, "box: upper corner");
  }
  if (every_type || c.type == Type::sphere) {
    visitor.field("center", c.point, kVec3, "sphere");
    visitor.field("radius", c.radius, kPositive, "sphere");
  }
  visitor.field("mode", choice(c.mode, kColliderModes), {}, "");
  visitor.field("friction", c.friction, kNotNegative, "Coulomb coefficient");
}

// A visitor has, besides `field`, a `section`: fields that follow stand in the object of that name, which the slices of
// `stages` hold whole; `add_to`, where it is given, names further stages that need just this field. `top` ends
// sections.
template <class Run, class Visitor>
void visit_fields(Run& run, Visitor& v) {
  v.section("grid", kGround | kLift | kCandidates | kSimulate, "");
  v.field("n", run.grid.n, between(16, 512), "cells per axis");
  v.field("length", run.grid.length, kPositive, "edge L of the solver cube");

  v.section("placement", kGround | kLift | kCandidates | kSimulate, "");
  v.field("extent", run.placement.extent, kPositive, "longest side of the scene in solver space");
  v.field("center", run.placement.center, kVec3, "where the centre of the scene's bounding box lies in solver space");
  v.field("up", run.placement.up, {"axis"}, "");

  v.section("time", kGround | kCandidates | kSimulate | kRender, "");
  v.field("frames", run.time.frames, between(1, 10000), "T, the rest frame included", kScreen);
  v.field("frame_dt", run.time.frame_dt, kPositive, "seconds between frames");
  v.field("substep_dt", run.time.substep_dt, kPositive, "base integration step, seconds");
  v.field("min_substep_dt", run.time.min_substep_dt, kPositive, "seconds");
  v.field("max_substeps", run.time.max_substeps, between(1, 1000000), "per output frame");
  v.field("rule", choice(run.time.rule, kTimeRules), {},
          "how pm-simulate steps: as pm-candidates recorded (paper), or as small as stability asks (cfl)");
  v.field("on_divergence", choice(run.time.on_divergence, kOnDivergence), {},
          "stop: a diverged candidate is a result; cfl: it is simulated once more with the rule cfl");
  v.field("retry_substeps", run.time.retry_substeps, between(1, 1000000000),
          "what that second simulation may take in all; one that needs more is not begun");
  v.field(
      "stiff", choice(run.time.stiff, kStiffRules), {},
      "rows too stiff for a third of the substep. off: they deform all the same, as the paper has it; rigid: they keep "
      "their shape; auto: those that would hardly bend do");
  v.field(
      "start", choice(run.time.start, kStarts), {},
      "rest: without stress, F = I, as the paper has it; equilibrium: what is supported carries its weight from the "
      "first substep on");

  v.top();
  v.field("gravity", along_up(run.gravity, run.placement.up_vector()), {},
          "acceleration along up (m/s^2 in solver space, negative is down), or a vector", kSimulate);
  v.field("colliders", run.colliders, {}, "", kSimulate);
  v.field("walls", run.walls, between(3, 16), "cells between the domain's faces and its walls",
          kGround | kLift | kCandidates | kSimulate);

  v.section("contact", kSimulate, "");
  v.field(
      "objects", choice(run.contact.objects, kContacts), {},
      "stick: objects that touch move with one velocity field, as the paper has it; separate: they push and rub, and "
      "part again");
  v.field("friction", run.contact.friction, kNotNegative, "Coulomb coefficient between objects that are separate");

  v.section("particles", kLift, "");
  v.field("max", run.particles.max, between(1, 10000000),
          "Gaussians and filled particles together; of more Gaussians some are simulated and carry the others");
  v.field("per_cell", run.particles.per_cell, between(1, 64), "filling density");
  v.field("fill", run.particles.fill, {}, "false: Gaussians only");

  v.section("segmentation", kGround, "");
  v.field("grabcut", run.segmentation.grabcut, {},
          "whether the built-in segmenter refines the boundaries between parts");

  v.section("lifting", kLift, "");
  v.field(
      "occlusion", choice(run.lifting.occlusion, kOcclusions), {},
      "none: evidence from every view that a Gaussian projects into, as the paper writes it; depth: only from views "
      "that see it");
  v.field("islands", choice(run.lifting.islands, kIslands), {},
          "join: small pieces of a row that hang apart from it are given to the row that they touch; keep: they stay");
  v.field("field_reach", run.lifting.field_reach, above(0, 512),
          "cells within which a particle takes the numbers of a material field's nearest sample. Not given: twice the "
          "samples' spacing, and two cells at least");

  v.section("profile", kSimulate, "constants of the six solver profiles, solver-space pascals");
  v.field("foam_yield", run.profile.foam_yield, kPositive, "");
  v.field("foam_viscosity", run.profile.foam_viscosity, kNotNegative, "");
  v.field("plasticine_yield", run.profile.plasticine_yield, kPositive, "");
  v.field("plasticine_softening", run.profile.plasticine_softening, kNotNegative, "");
  v.field("plasticine_residual", run.profile.plasticine_residual, kUnit, "");
  v.field("sand_friction_angle", run.profile.sand_friction_angle, between(0, 80), "degrees");
  v.field("alpha", run.profile.alpha, kPositive, "Drucker-Prager slope of Sand, Snow and Plasticine");
  v.field("sand_k", run.profile.sand_k, kNotNegative, "");
  v.field("snow_k", run.profile.snow_k, kNotNegative, "");
  v.field("plasticine_k", run.profile.plasticine_k, kNotNegative, "");

  v.section("projection", kCandidates, "");
  v.field(
      "mode", choice(run.projection.rigid, kProjectionModes), {},
      "structure projection. literal: the rest shape is not turned, as the paper prints it; rigid: it turns with the "
      "row");

  v.section("controls", kCandidates, "");
  v.field("release", choice(run.controls.literal_release, kReleases), {},
          "how presses, squeezes, twists and stretches end. hand: what springs back is held by a hand that goes back; "
          "literal: it is let go at once");
  v.field("stiff", choice(run.controls.blend_stiff, kStiffDrives), {},
          "twists of rows too stiff for a bounded force. enforced: they are turned all the same; blended: they resist");

  v.section("transport", kSimulate, "");
  v.field("deformation", choice(run.transport.total, kDeformations), {},
          "what carries the Gaussians. elastic: F after the return map; total: without return maps");

  v.section("screening", kScreen, "");
  v.field("initial", run.screening.initial, between(1, 10), "candidates retained for round 0", kCandidates);
  v.field("rounds", run.screening.rounds, between(1, 3), "", kCandidates);
  v.field("repairs", run.screening.repairs, between(0, 6), "new candidates per repair round", kCandidates);
  v.field("tau", run.screening.tau, {}, "acceptance threshold of Q");
  v.field("excuse_rotation", run.screening.excuse_rotation, {},
          "what fails spread or flattening in the image passes where both hold in the objects' own frame; false: image "
          "boxes alone, as the paper writes it");
  v.field("achieved_min", run.screening.achieved_min, kUnit,
          "gate: the smallest share of its request that an action must have met; 0: no gate");
  v.field(
      "stillness_min", run.screening.stillness_min, kUnit,
      "gate: how still what nothing moved or touched must have stood; 0: no gate. Not given: 0.5 where the prompt asks "
      "for no motion, else no gate");
  v.field("dark_luminance", run.screening.dark_luminance, kUnit,
          "a foreground pixel below this Rec. 709 luminance is dark", kRender);
  v.field("weights", run.screening.weights, {},
          "w of Q: video, part confidence, diversity, role, base, density, solver");

  v.section("ablation", 0, "studies: false takes a part of the method out");
  v.field("object_part_state", run.ablation.object_part_state, {}, "false: every object is one part with one material",
          kGround);
  v.field("structure_projection", run.ablation.structure_projection, {},
          "false: no projection weights and no interface retention", kCandidates);
  v.field("part_materials", run.ablation.part_materials, {},
          "false: all rows of an object have the material of its largest one, without projection and retention",
          kCandidates);

  v.section("render", kRender, "");
  v.field("width", run.render.width, between(16, 8192), "");
  v.field("height", run.render.height, between(16, 8192), "");
  v.field("background", run.render.background, {"color"}, "", kGround);
  v.field("sh_degree", run.render.sh_degree, between(0, 3), "highest degree that is evaluated");
  v.field("camera", choice(run.render.camera, kCameraModes), {},
          "of the video. fixed (default): the scene's output cameras; fit: moved back as far as it takes to keep what "
          "moves "
          "in the picture; orbit: and turning slowly about the scene");
  v.field("floor", choice(run.render.floor, kFloors), {},
          "of the video. shadow: the floor with soft shadows under the Gaussians; none (default)");
  v.field("agents", run.render.agents, {},
          "of the video. true: a sign where an action acts, while it does; default false");
}

}  // namespace physmas

#endif
