#include "mpm/action/projection.h"

#include <algorithm>

#include "mpm/action/nearest.h"
#include "mpm/action/region.h"
#include "mpm/math/svd.h"

namespace physmas::mpm {

namespace {

Vec3d mean_of(const std::vector<Vec3d>& values, const std::vector<int>& particles) {
  Vec3d sum{0, 0, 0};
  for (const int i : particles) sum = sum + values[i];
  return (1.0 / static_cast<double>(particles.size())) * sum;
}

std::vector<Vec3d> offsets_from(const Vec3d& mean, const std::vector<int>& particles, const Particles& rest) {
  std::vector<Vec3d> offsets;
  offsets.reserve(particles.size());
  for (const int i : particles) offsets.push_back(rest.position[i] - mean);
  return offsets;
}

Vec3d blend(double weight, const Vec3d& towards, const Vec3d& from) {
  return (1 - weight) * from + weight * towards;
}

// The rotation that fits the rest offsets to the present ones best in the least-squares sense (Kabsch 1976).
Mat3d best_rotation(const std::vector<Vec3d>& x, const std::vector<int>& particles, const std::vector<Vec3d>& offset,
                    const Vec3d& center) {
  Mat3d sum = diagonal(0.0, 0.0, 0.0);
  double scale = 0;
  for (size_t k = 0; k < particles.size(); ++k) {
    const Vec3d now = x[particles[k]] - center;
    for (int a = 0; a < 3; ++a) sum[a] = sum[a] + now[a] * offset[k];
    scale += dot(offset[k], offset[k]);
  }
  // Rows without extent in some direction leave the rotation open there: a whiff of the identity decides.
  return polar_rotation(sum + (1e-9 * scale) * identity<double>());
}

// The angular velocity [1/s] whose rigid motion fits the row's velocities best: L = I ω for particles of equal mass.
Vec3d best_spin(const State& state, const std::vector<int>& particles, const Vec3d& center, const Vec3d& velocity) {
  Mat3d inertia = diagonal(0.0, 0.0, 0.0);
  Vec3d momentum{0, 0, 0};
  for (const int i : particles) {
    const Vec3d r = state.x[i] - center;
    momentum = momentum + cross(r, state.v[i] - velocity);
    inertia = inertia + dot(r, r) * identity<double>();
    for (int a = 0; a < 3; ++a) inertia[a] = inertia[a] - r[a] * r;
  }
  // About an axis that all particles lie on there is nothing to turn.
  const Svd<double> d = svd(inertia);
  const Vec3d along = transpose(d.U) * momentum;
  Vec3d spin{0, 0, 0};
  for (int a = 0; a < 3; ++a) {
    if (d.s[a] > 1e-9 * d.s[0]) spin[a] = along[a] / d.s[a];
  }
  return transpose(d.Vt) * spin;
}

// Where a row is and how it moves: as a point, or also as a body that turns.
struct RowMotion {
  Vec3d center, velocity;  // of the mean
  Mat3d rotation;          // of the rest shape
  Mat3d spin;              // angular velocity as a matrix [1/s]
};

RowMotion motion_of(const State& state, const std::vector<int>& particles, const std::vector<Vec3d>& offset,
                    StructureProjection::Mode mode) {
  RowMotion motion;
  motion.center = mean_of(state.x, particles);
  motion.velocity = mean_of(state.v, particles);
  const bool turns = mode == StructureProjection::Mode::rigid;
  motion.rotation = turns ? best_rotation(state.x, particles, offset, motion.center) : identity<double>();
  const Vec3d w = turns ? best_spin(state, particles, motion.center, motion.velocity) : Vec3d{0, 0, 0};
  motion.spin = {{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}}};
  return motion;
}

}  // namespace

CompiledProjection::CompiledProjection(const StructureProjection& projection, const Particles& rest)
    : eta_(projection.eta), mode_(projection.mode), particles_(particles_of_rows({projection.row}, rest)) {
  if (!particles_.empty()) offset_ = offsets_from(mean_of(rest.position, particles_), particles_, rest);
  if (rest.deformation_gradient.empty()) return;
  for (const int i : particles_) F0_.push_back(rest.deformation_gradient[i]);
}

void CompiledProjection::apply(State& state) const {
  if (particles_.empty()) return;
  const RowMotion row = motion_of(state, particles_, offset_, mode_);
  for (size_t k = 0; k < particles_.size(); ++k) {
    const int i = particles_[k];
    const Vec3d offset = row.rotation * offset_[k];
    state.x[i] = blend(eta_, row.center + offset, state.x[i]);
    state.v[i] = blend(eta_, row.velocity + row.spin * offset, state.v[i]);
    state.F[i] = (1 - eta_) * state.F[i] + eta_ * (F0_.empty() ? row.rotation : row.rotation * F0_[k]);
    state.C[i] = (1 - eta_) * state.C[i] + eta_ * row.spin;
    if (!state.total_F.empty()) state.total_F[i] = (1 - eta_) * state.total_F[i] + eta_ * row.rotation;
  }
}

std::vector<CompiledRetention> CompiledRetention::compile(const std::vector<InterfaceRetention>& retentions,
                                                          const Particles& rest,
                                                          const std::vector<StructureProjection>& projections) {
  const size_t count = rest.size();
  std::vector<double> nearest(count, std::numeric_limits<double>::infinity());  // squared, to the nearest support
  std::vector<int> owner(count, -1);
  std::vector<CompiledRetention> compiled(retentions.size());
  for (size_t r = 0; r < retentions.size(); ++r) {
    compiled[r].eta_ = retentions[r].eta;
    compiled[r].zeta_ = retentions[r].zeta;
    for (const StructureProjection& projection : projections) {
      if (projection.row == retentions[r].support) compiled[r].mode_ = projection.mode;
    }
    compiled[r].support_ = particles_of_rows({retentions[r].support}, rest);
    if (compiled[r].support_.empty()) continue;
    const NearestAtRest tree(rest, compiled[r].support_);
    for (const int i : particles_of_rows(retentions[r].rows, rest)) {
      const double squared = tree.squared_distance(rest.position[i]);
      if (std::sqrt(squared) <= retentions[r].distance && squared < nearest[i]) {
        nearest[i] = squared;
        owner[i] = static_cast<int>(r);
      }
    }
  }
  for (size_t i = 0; i < count; ++i) {
    if (owner[i] >= 0) compiled[owner[i]].particles_.push_back(static_cast<int>(i));
  }
  for (size_t r = 0; r < retentions.size(); ++r) {
    std::vector<int>& kept = compiled[r].particles_;
    std::stable_sort(kept.begin(), kept.end(), [&](int a, int b) { return nearest[a] < nearest[b]; });
    if (kept.size() > static_cast<size_t>(retentions[r].limit)) kept.resize(retentions[r].limit);
    if (kept.empty()) continue;
    const Vec3d center = mean_of(rest.position, compiled[r].support_);
    compiled[r].offset_ = offsets_from(center, kept, rest);
    compiled[r].support_offset_ = offsets_from(center, compiled[r].support_, rest);
  }
  return compiled;
}

void CompiledRetention::apply(State& state) const {
  if (particles_.empty()) return;
  const RowMotion row = motion_of(state, support_, support_offset_, mode_);
  for (size_t k = 0; k < particles_.size(); ++k) {
    const int i = particles_[k];
    const Vec3d offset = row.rotation * offset_[k];
    state.x[i] = blend(eta_, row.center + offset, state.x[i]);
    state.v[i] = blend(zeta_, row.velocity + row.spin * offset, state.v[i]);
  }
}

}  // namespace physmas::mpm
