#include "bind/stillness.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "bind/achievement.h"
#include "mpm/action/collider.h"

namespace physmas::bind {
namespace {

using mpm::Vec3d;

// Whether a place is on an obstacle, or at the wall that gravity pulls to. Particles are half their spacing from what
// they stand on, and contact acts on nodes up to a cell and a half away.
bool supported(const Vec3d& x, const mpm::Domain& domain) {
  const double near = 1.5 * domain.dx();
  for (const mpm::Collider& collider : domain.colliders) {
    if (mpm::locate(collider, x).distance < near) return true;
  }
  const double wall = domain.wall_cells * domain.dx() + near;
  for (int a = 0; a < 3; ++a) {
    if (domain.gravity[a] < 0 && x[a] < wall) return true;
    if (domain.gravity[a] > 0 && x[a] > domain.length - wall) return true;
  }
  return false;
}

}  // namespace

StillnessMeter::StillnessMeter(const Candidate& candidate, const mpm::Problem& problem)
    : near_(2 * problem.domain.dx()), longest_side_(longest_side(problem.particles.position)) {
  std::set<int> acted_on;
  for (const ScheduleOperation& op : candidate.schedule) {
    if (!op.is_action()) continue;
    acted_on.insert(op.rows.begin(), op.rows.end());
    acted_on.insert(op.neighbours.begin(), op.neighbours.end());
  }
  const mpm::Particles& rest = problem.particles;
  const bool weightless = norm(problem.domain.gravity) == 0;
  for (const CandidateRow& candidate_row : candidate.rows) {
    Row row;
    row.key = candidate_row.key;
    row.particles = mpm::particles_of_rows({candidate_row.row}, rest);
    if (row.particles.empty()) continue;
    row.moves = acted_on.count(candidate_row.row) > 0;
    row.stands = weightless;
    for (const int i : row.particles) {
      row.rest.push_back(rest.position[i]);
      row.stands = row.stands || supported(rest.position[i], problem.domain);
    }
    rows_.push_back(std::move(row));
  }
}

std::vector<StillnessMeter::Box> StillnessMeter::boxes(const mpm::Frame& frame) const {
  std::vector<Box> list;
  for (const Row& row : rows_) {
    Box box{frame.state.x[row.particles[0]], frame.state.x[row.particles[0]]};
    for (const int i : row.particles) {
      for (int a = 0; a < 3; ++a) {
        box.low[a] = std::min(box.low[a], frame.state.x[i][a]);
        box.high[a] = std::max(box.high[a], frame.state.x[i][a]);
      }
    }
    list.push_back(box);
  }
  return list;
}

// Gives the quality to every row near one that has it, until nothing changes.
void StillnessMeter::spread(const std::vector<Box>& boxes, bool Row::*quality) {
  const auto near = [&](const Box& a, const Box& b) {
    for (int k = 0; k < 3; ++k) {
      if (a.low[k] > b.high[k] + near_ || b.low[k] > a.high[k] + near_) return false;
    }
    return true;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < rows_.size(); ++i) {
      for (size_t j = 0; j < rows_.size() && !(rows_[i].*quality); ++j) {
        if (rows_[j].*quality && near(boxes[i], boxes[j])) rows_[i].*quality = changed = true;
      }
    }
  }
}

void StillnessMeter::observe(const mpm::Frame& frame) {
  const std::vector<Box> now = boxes(frame);
  if (frame.index == 0) spread(now, &Row::stands);
  spread(now, &Row::moves);
  for (Row& row : rows_) {
    double sum = 0;
    for (size_t k = 0; k < row.particles.size(); ++k) sum += norm(frame.state.x[row.particles[k]] - row.rest[k]);
    row.drift = sum / static_cast<double>(row.particles.size());
  }
}

std::optional<Stillness> StillnessMeter::result() const {
  Stillness still;
  for (const Row& row : rows_) {
    // What cannot be measured is not still.
    if (row.moves || !row.stands) continue;
    still.rows.push_back(row.key);
    still.drift = std::max(still.drift, std::isfinite(row.drift) ? row.drift : longest_side_);
  }
  if (still.rows.empty()) return std::nullopt;
  still.share = stillness_share(still.drift, longest_side_);
  return still;
}

}  // namespace physmas::bind
