#include "mpm/rigid/stiff_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "mpm/material/constitutive.h"
#include "mpm/math/svd.h"
#include "mpm/timestep.h"

namespace physmas::mpm {

namespace {

// A row that a third of the substep integrates is cheaper as it is.
constexpr double kLeastRatio = 3;
constexpr double kLargestDeflection = 0.01;

double youngs_modulus(const MaterialParameters<double>& p) {
  return p.mu * (3 * p.lambda + 2 * p.mu) / (p.lambda + p.mu);
}

// Pieces of a set of particles: cells of the grid's size that touch, corners included.
std::vector<std::vector<int>> pieces_of(const std::vector<int>& particles, const Particles& rest, double dx) {
  std::map<std::array<int, 3>, std::vector<int>> cells;
  for (const int i : particles) {
    std::array<int, 3> cell;
    for (int a = 0; a < 3; ++a) cell[a] = static_cast<int>(std::floor(rest.position[i][a] / dx));
    cells[cell].push_back(i);
  }
  std::vector<std::vector<int>> pieces;
  while (!cells.empty()) {
    std::vector<std::array<int, 3>> open = {cells.begin()->first};
    std::vector<int> piece = std::move(cells.begin()->second);
    cells.erase(cells.begin());
    while (!open.empty()) {
      const std::array<int, 3> at = open.back();
      open.pop_back();
      for (int k = 0; k < 27; ++k) {
        const auto found = cells.find({at[0] + k / 9 - 1, at[1] + k / 3 % 3 - 1, at[2] + k % 3 - 1});
        if (found == cells.end()) continue;
        piece.insert(piece.end(), found->second.begin(), found->second.end());
        open.push_back(found->first);
        cells.erase(found);
      }
    }
    std::sort(piece.begin(), piece.end());
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

// What an action asks of a row that keeps its shape.
struct Asked {
  int enforced = 0;               // actions that enforce a motion of all of it
  const char* deforms = nullptr;  // the action that asks it to deform
};

bool acts_on(const std::vector<int>& rows, int row) {
  return std::find(rows.begin(), rows.end(), row) != rows.end();
}

struct Ask {
  Asked& asked;
  void operator()(const Translation&) const { ++asked.enforced; }
  void operator()(const SlabMotion&) const { ++asked.enforced; }
  void operator()(const ScaleSlab&) const { asked.deforms = "a stretch"; }
  void operator()(const VerticalCompress&) const { asked.deforms = "a press"; }
  void operator()(const SideCompress&) const { asked.deforms = "a squeeze"; }
  void operator()(const RadialSpread&) const { asked.deforms = "a spread"; }
  void operator()(const Torque& t) const {
    if (!t.enforced) return;
    if (t.slab_fraction < 1) {
      asked.deforms = "a twist";
    } else {
      ++asked.enforced;
    }
  }
  void operator()(const Impulse&) const {}
  void operator()(const DragFollow&) const {}
};

Asked asked_of(const std::vector<Action>& actions, int row) {
  Asked asked;
  for (const Action& action : actions) {
    std::visit(
        [&](const auto& a) {
          if (acts_on(a.rows, row)) Ask{asked}(a);
        },
        action);
  }
  return asked;
}

// Extents [m] of a body, as those of a uniform block with its inertia.
void extents(const RigidBodyRest& rest, double dx, double& longest, double& smallest) {
  // Second moments from the tensor of inertia: Σ m d_a² = (tr I)/2 − I_a, without what the grid's weights add.
  const Svd<double> d = svd(rest.inertia);
  const double half = 0.5 * (d.s[0] + d.s[1] + d.s[2]) - 0.25 * rest.mass * dx * dx;
  const double least = std::max(0.0, half - d.s[0]), most = std::max(0.0, half - d.s[2]);
  longest = std::sqrt(12 * most / rest.mass);
  smallest = std::sqrt(12 * least / rest.mass);
}

RigidBodyRest body_at_rest(const std::vector<int>& particles, const StiffProblem& p, const std::vector<double>& mass) {
  RigidBodyRest body;
  body.particles = particles;
  Vec3d first{0, 0, 0};
  const Vec3d near = p.particles.position[particles.front()];
  for (const int i : particles) {
    body.mass += mass[i];
    first = first + mass[i] * (p.particles.position[i] - near);
  }
  body.center = near + (1 / body.mass) * first;
  body.inertia = (0.5 * body.mass * p.dx * p.dx) * identity<double>();
  for (const int i : particles) {
    const Vec3d d = p.particles.position[i] - body.center;
    body.inertia = body.inertia + (mass[i] * dot(d, d)) * identity<double>();
    for (int a = 0; a < 3; ++a) body.inertia[a] = body.inertia[a] - (mass[i] * d[a]) * d;
    body.radius = std::max(body.radius, norm(d));
  }
  return body;
}

}  // namespace

double rigid_error(const RigidBodyRest& rest, double dx, const MaterialParameters<double>& material,
                   double acceleration) {
  double longest, smallest;
  extents(rest, dx, longest, smallest);
  if (!(smallest > 0)) return 0;
  // First bending frequency of a free beam of height h: (4.730)² h / √12 / L² √(E/ρ).
  const double frequency =
      6.459 * smallest / (longest * longest) * std::sqrt(youngs_modulus(material) / material.density);
  return acceleration / (frequency * frequency * longest);
}

RigidPlan plan_rigid(const StiffProblem& p, StiffRule rule, double dt) {
  RigidPlan plan;
  plan.row = p.particles.row;
  plan.source_row.resize(p.branches.size());
  std::iota(plan.source_row.begin(), plan.source_row.end(), 0);
  plan.setup.body_of_row.assign(p.branches.size(), -1);
  const int rows = static_cast<int>(p.branches.size());
  const size_t count = p.particles.size();
  const auto parameters_of = [&](size_t i) {
    const MaterialParameters<double>& own = p.parameters[p.particles.row[i]];
    return p.elasticity.empty() ? own : with_elasticity(own, p.elasticity[i]);
  };
  std::vector<double> limit(rows, std::numeric_limits<double>::infinity()), mass(count);
  for (size_t i = 0; i < count; ++i) {
    const MaterialParameters<double> own = parameters_of(i);
    mass[i] = own.density * p.particles.volume[i];
    double& least = limit[p.particles.row[i]];
    least = std::min(least, rest_limit(own, p.dx));
  }
  if (rule == StiffRule::off) return plan;

  std::vector<int> listed(rows, -1);
  for (int row = 0; row < rows; ++row) {
    if (!(limit[row] < dt)) continue;
    StiffRow stiff;
    stiff.row = row;
    stiff.limit = limit[row];
    const Asked asked = asked_of(p.actions, row);
    if (p.branches[row] != Branch::jelly && p.branches[row] != Branch::metal) {
      stiff.why = fmt::format("{} yields", branch_name(p.branches[row]));
    } else if (kWaveShare * limit[row] >= dt / kLeastRatio) {
      stiff.why = "smaller substeps are cheaper";
    } else if (p.separate_contact) {
      stiff.why = "objects are separate bodies in contact";
    } else if (asked.deforms) {
      stiff.why = fmt::format("{} acts on it", asked.deforms);
    } else if (asked.enforced > 1) {
      stiff.why = "several actions hold it";
    } else {
      stiff.rigid = true;
      stiff.why = "its stable step is below a third of the substep";
    }
    listed[row] = static_cast<int>(plan.rows.size());
    plan.rows.push_back(stiff);
  }
  const auto rigid = [&](int row) { return listed[row] >= 0 && plan.rows[listed[row]].rigid; };

  // Pieces by object, so that what touches of one object is welded.
  std::map<int, std::vector<int>> of_object;
  for (size_t i = 0; i < count; ++i) {
    const int row = p.particles.row[i];
    if (rigid(row)) of_object[p.object.empty() ? 0 : p.object[row]].push_back(static_cast<int>(i));
  }
  struct Piece {
    int object;
    RigidBodyRest body;
  };
  std::vector<Piece> pieces;
  for (const auto& [object, particles] : of_object) {
    for (const auto& piece : pieces_of(particles, p.particles, p.dx)) {
      pieces.push_back({object, body_at_rest(piece, p, mass)});
    }
  }
  // A row bends as its most slender piece does.
  for (const Piece& piece : pieces) {
    for (const int i : piece.body.particles) {
      StiffRow& stiff = plan.rows[listed[p.particles.row[i]]];
      if (stiff.deflection > 0) continue;
      stiff.deflection = rigid_error(piece.body, p.dx, parameters_of(i), norm(p.gravity));
      if (rule == StiffRule::automatic && stiff.deflection > kLargestDeflection) {
        stiff.rigid = false;
        stiff.why = fmt::format("it bends by {:.1f} % of its length under its own weight", 100 * stiff.deflection);
      }
    }
  }
  pieces.erase(std::remove_if(pieces.begin(), pieces.end(),
                              [&](const Piece& piece) {
                                return std::any_of(piece.body.particles.begin(), piece.body.particles.end(),
                                                   [&](int i) { return !rigid(p.particles.row[i]); });
                              }),
               pieces.end());
  // Crumbs go with the nearest large piece of their object: there are fields for so many bodies only.
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.body.mass > b.body.mass; });
  while (pieces.size() > static_cast<size_t>(kMostRigidBodies)) {
    const Piece crumb = std::move(pieces.back());
    pieces.pop_back();
    int home = -1;
    for (size_t k = 0; k < pieces.size(); ++k) {
      if (pieces[k].object != crumb.object) continue;
      const auto distance = [&](size_t j) { return norm(pieces[j].body.center - crumb.body.center); };
      if (home < 0 || distance(k) < distance(home)) home = static_cast<int>(k);
    }
    if (home < 0) {
      for (const int i : crumb.body.particles) {
        StiffRow& stiff = plan.rows[listed[p.particles.row[i]]];
        stiff.rigid = false;
        stiff.why = fmt::format("more than {} bodies are stiff", kMostRigidBodies);
      }
      continue;
    }
    std::vector<int> both = pieces[home].body.particles;
    both.insert(both.end(), crumb.body.particles.begin(), crumb.body.particles.end());
    std::sort(both.begin(), both.end());
    pieces[home].body = body_at_rest(both, p, mass);
  }
  pieces.erase(std::remove_if(pieces.begin(), pieces.end(),
                              [&](const Piece& piece) { return !rigid(p.particles.row[piece.body.particles[0]]); }),
               pieces.end());
  if (pieces.empty()) return plan;

  plan.setup.offset.assign(count, {0, 0, 0});
  plan.setup.F = p.particles.deformation_gradient;
  std::vector<bool> taken(rows, false);
  for (const Piece& piece : pieces) {
    const int b = static_cast<int>(plan.setup.bodies.size());
    RigidBodyRest body = piece.body;
    std::map<int, int> row_here;  // the problem's row → the stepper's
    body.limit = std::numeric_limits<double>::infinity();
    for (const int i : body.particles) {
      const int source = p.particles.row[i];
      body.limit = std::min(body.limit, rest_limit(parameters_of(i), p.dx));
      plan.setup.offset[i] = p.particles.position[i] - body.center;
      const auto [it, fresh] = row_here.try_emplace(source, source);
      if (fresh) {
        plan.rows[listed[source]].bodies.push_back(b);
        if (taken[source]) {
          it->second = static_cast<int>(plan.source_row.size());
          plan.source_row.push_back(source);
          plan.setup.body_of_row.push_back(b);
        } else {
          taken[source] = true;
          plan.setup.body_of_row[source] = b;
        }
      }
      plan.row[i] = it->second;
    }
    body.lock = 4 / (body.limit * body.limit);
    plan.setup.bodies.push_back(std::move(body));
  }
  return plan;
}

}  // namespace physmas::mpm
