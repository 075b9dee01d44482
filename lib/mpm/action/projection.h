// Operations at output frames: structure projection and interface retention. Both act on the state after G2P and before
// the frame is handed out; the corrected state seeds the next interval.
#ifndef PHYSMAS_MPM_ACTION_PROJECTION_H
#define PHYSMAS_MPM_ACTION_PROJECTION_H

#include <vector>

#include "mpm/state.h"

namespace physmas::mpm {

// Relaxes a support-like row towards its rest shape around its current centre (paper, Eqs. "structuremotion",
// "structurestate"). Means are unweighted, over all particles of the row. Where particles begin with an elastic F of
// their own, that is what belongs to the rest shape and takes the place of the identity.
struct StructureProjection {
  // literal: the rest shape is not rotated, F goes to the identity, velocities to their mean, as the paper prints it.
  // rigid: the rest shape is turned by the row's best-fit rotation R, F goes to R, and velocities to the rigid motion
  // that fits them best, so that a support may topple.
  enum class Mode { literal, rigid };
  int row = 0;
  double eta = 0.85;  // 0..1; 1 restores the rest shape
  Mode mode = Mode::literal;
};

// Keeps particles that were close to a support at rest in their place relative to it (paper, "Initial-Neighborhood
// Interface Retention"). Where the support has a rigid structure projection, that place turns with it, and velocities
// go to the support's rigid motion instead of its mean velocity.
struct InterfaceRetention {
  int support = 0;          // row r
  std::vector<int> rows;    // candidate rows: of the same object, without the support
  double distance = 0.045;  // d_b [m]: farthest rest distance to a particle of the support
  int limit = 26000;        // particles kept, by ascending distance, ties by index
  double eta = 0.95;        // weight of the position
  double zeta = 0.95;       // weight of the velocity
};

// A projection with its particles and rest offsets δ_q = x_q⁰ − mean of the support's x⁰.
class CompiledProjection {
 public:
  CompiledProjection(const StructureProjection& projection, const Particles& rest);
  void apply(State& state) const;
  bool empty() const { return particles_.empty(); }

 private:
  double eta_;
  StructureProjection::Mode mode_;
  std::vector<int> particles_;
  std::vector<Vec3d> offset_;
  std::vector<Mat3d> F0_;  // or empty: identity
};

class CompiledRetention {
 public:
  // A particle that is near several supports belongs to the nearest one, the earlier on ties, so retentions compile
  // together. projections: those that act before the retentions.
  static std::vector<CompiledRetention> compile(const std::vector<InterfaceRetention>& retentions,
                                                const Particles& rest,
                                                const std::vector<StructureProjection>& projections = {});
  void apply(State& state) const;
  const std::vector<int>& particles() const { return particles_; }  // retained, by ascending rest distance

 private:
  double eta_ = 0, zeta_ = 0;
  StructureProjection::Mode mode_ = StructureProjection::Mode::literal;
  std::vector<int> support_, particles_;
  std::vector<Vec3d> support_offset_, offset_;
};

}  // namespace physmas::mpm

#endif
