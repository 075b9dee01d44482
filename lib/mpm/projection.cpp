#include "mpm/projection.h"

#include <algorithm>
#include <nanoflann.hpp>

#include "mpm/action_velocity.h"

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

// The view of some particles' rest positions that nanoflann searches.
struct Cloud {
  const Particles& rest;
  const std::vector<int>& particles;
  size_t kdtree_get_point_count() const { return particles.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return rest.position[particles[i]][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

CompiledProjection::CompiledProjection(const StructureProjection& projection, const Particles& rest)
    : eta_(projection.eta), particles_(particles_of_rows({projection.row}, rest)) {
  if (!particles_.empty()) offset_ = offsets_from(mean_of(rest.position, particles_), particles_, rest);
}

void CompiledProjection::apply(State& state) const {
  if (particles_.empty()) return;
  const Vec3d center = mean_of(state.x, particles_);
  const Vec3d velocity = mean_of(state.v, particles_);
  for (size_t k = 0; k < particles_.size(); ++k) {
    const int i = particles_[k];
    state.x[i] = blend(eta_, center + offset_[k], state.x[i]);
    state.v[i] = blend(eta_, velocity, state.v[i]);
    state.F[i] = (1 - eta_) * state.F[i] + eta_ * identity<double>();
    state.C[i] = (1 - eta_) * state.C[i];
  }
}

std::vector<CompiledRetention> CompiledRetention::compile(const std::vector<InterfaceRetention>& retentions,
                                                          const Particles& rest) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;
  const size_t count = rest.size();
  std::vector<double> nearest(count, std::numeric_limits<double>::infinity());  // squared, to the nearest support
  std::vector<int> owner(count, -1);
  std::vector<CompiledRetention> compiled(retentions.size());
  for (size_t r = 0; r < retentions.size(); ++r) {
    compiled[r].eta_ = retentions[r].eta;
    compiled[r].zeta_ = retentions[r].zeta;
    compiled[r].support_ = particles_of_rows({retentions[r].support}, rest);
    if (compiled[r].support_.empty()) continue;
    const Cloud cloud{rest, compiled[r].support_};
    const Tree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    for (const int i : particles_of_rows(retentions[r].rows, rest)) {
      size_t index;
      double squared;
      nanoflann::KNNResultSet<double> result(1);
      result.init(&index, &squared);
      tree.findNeighbors(result, &rest.position[i].x, nanoflann::SearchParams());
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
    if (!kept.empty()) compiled[r].offset_ = offsets_from(mean_of(rest.position, compiled[r].support_), kept, rest);
  }
  return compiled;
}

void CompiledRetention::apply(State& state) const {
  if (particles_.empty()) return;
  const Vec3d center = mean_of(state.x, support_);
  const Vec3d velocity = mean_of(state.v, support_);
  for (size_t k = 0; k < particles_.size(); ++k) {
    const int i = particles_[k];
    state.x[i] = blend(eta_, center + offset_[k], state.x[i]);
    state.v[i] = blend(zeta_, velocity, state.v[i]);
  }
}

}  // namespace physmas::mpm
