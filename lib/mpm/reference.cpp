#include "mpm/reference.h"

#include <algorithm>
#include <cmath>

#include "mpm/action/collider.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm::reference {

namespace {

constexpr double kSafeCells = 2;  // particles stay so far inside: every node of a stencil exists

// Quadratic B-spline of a distance in cells (Steffen et al. 2008).
double spline(double distance) {
  const double d = std::fabs(distance);
  if (d < 0.5) return 0.75 - d * d;
  return d < 1.5 ? 0.5 * (1.5 - d) * (1.5 - d) : 0;
}

// Calls function(node, w_aq, x_a − x_q) for the 27 nodes of a particle at x.
template <class Function>
void for_each_node(const Grid& grid, double dx, const Vec3d& x, const Function& function) {
  int base[3];
  for (int a = 0; a < 3; ++a) base[a] = static_cast<int>(std::floor(x[a] / dx - 0.5));
  for (int i = base[0]; i < base[0] + 3; ++i) {
    for (int j = base[1]; j < base[1] + 3; ++j) {
      for (int k = base[2]; k < base[2] + 3; ++k) {
        const Vec3d offset = Vec3d{i * dx, j * dx, k * dx} - x;
        const double w = spline(offset.x / dx) * spline(offset.y / dx) * spline(offset.z / dx);
        function((i * grid.nodes + j) * grid.nodes + k, w, offset);
      }
    }
  }
}

Branch branch_of(const StepperSetup& setup, size_t particle) {
  return setup.branches[setup.row[particle]];
}

// The action's field at x (control.h).
Increment field_at(const Control& c, const Vec3d& x) {
  const Vec3d free = c.velocity + c.gradient * (x - c.center);
  const double speed = norm(free);
  const double scale = speed > c.speed_limit ? c.speed_limit / speed : 1;
  return {scale * free, scale * c.gradient};
}

// `from`, moved towards `to` by the weights along and across the control's axis.
Vec3d blended(const Vec3d& from, const Vec3d& to, const Vec3d& axis, const Control::Weight& weight) {
  const Vec3d difference = to - from;
  const Vec3d along = dot(axis, difference) * axis;
  return from + weight.along * along + weight.across * (difference - along);
}
Mat3d blended(const Mat3d& from, const Mat3d& to, const Vec3d& axis, const Control::Weight& weight) {
  // Column by column: each is the change of the velocity along one direction.
  Mat3d columns = transpose(from);
  const Mat3d target = transpose(to);
  for (int b = 0; b < 3; ++b) columns[b] = blended(columns[b], target[b], axis, weight);
  return transpose(columns);
}

}  // namespace

Grid::Grid(const Domain& domain)
    : nodes(domain.n + 1),
      mass(static_cast<size_t>(nodes) * nodes * nodes, 0.0),
      momentum(mass.size(), {0, 0, 0}),
      velocity(mass.size(), {0, 0, 0}) {}

void blend_actions(const StepperSetup& setup, const std::vector<Control>& controls, State& state) {
  for (size_t q = 0; q < state.size(); ++q) {
    const Control& c = controls[setup.control_group[q]];
    const Increment field = field_at(c, state.x[q]);
    state.v[q] = blended(state.v[q], field.velocity, c.axis, c.blend) + c.change;
    state.C[q] = blended(state.C[q], field.gradient, c.axis, c.blend);
  }
}

Grid p2g(const StepperSetup& setup, const State& state, double dt, int body) {
  Grid grid(setup.domain);
  const double dx = setup.domain.dx();
  for (size_t q = 0; q < state.size(); ++q) {
    if (setup.contact.of(setup.row[q]) != body) continue;
    const MaterialParameters<double> p = setup.parameters_of(q);
    const double mass = p.density * setup.volume[q];
    const Mat3d tau = branch_stress(branch_of(setup, q), p, state.F[q]);
    for_each_node(grid, dx, state.x[q], [&](int a, double w, const Vec3d& offset) {
      grid.mass[a] += w * mass;
      // f_a = −V⁰ τ ∇w with the gradient of moving least squares, ∇w = 4/dx² w (x_a − x_q) (Hu et al. 2018).
      const Vec3d force = -(4 * setup.volume[q] * w / (dx * dx)) * (tau * offset);
      grid.momentum[a] = grid.momentum[a] + (w * mass) * (state.v[q] + state.C[q] * offset) + dt * force;
    });
  }
  return grid;
}

void grid_update(const Domain& domain, double dt, Grid& grid) {
  for (size_t a = 0; a < grid.mass.size(); ++a) {
    if (grid.mass[a] > 0) grid.velocity[a] = (1 / grid.mass[a]) * grid.momentum[a] + dt * domain.gravity;
  }
}

void meet(const StepperSetup& setup, std::vector<Grid>& grids) {
  const int n = grids[0].nodes;
  for (int a = 0; a < n * n * n; ++a) {
    std::vector<BodyAtNode> here;
    std::vector<int> body;
    for (size_t b = 0; b < grids.size(); ++b) {
      const std::vector<double>& mass = grids[b].mass;
      if (!(mass[a] > 0)) continue;  // then a is no node of the boundary: particles stay away from it
      here.push_back({mass[a],
                      {0.5 * (mass[a + n * n] - mass[a - n * n]), 0.5 * (mass[a + n] - mass[a - n]),
                       0.5 * (mass[a + 1] - mass[a - 1])},
                      grids[b].velocity[a]});
      body.push_back(static_cast<int>(b));
    }
    mpm::meet(here.data(), static_cast<int>(here.size()), setup.contact.friction);
    for (size_t k = 0; k < here.size(); ++k) grids[body[k]].velocity[a] = here[k].u;
  }
}

void contact(const Domain& domain, Grid& grid) {
  for (size_t a = 0; a < grid.mass.size(); ++a) {
    if (!(grid.mass[a] > 0)) continue;
    const int n = grid.nodes, number = static_cast<int>(a);
    const int index[3] = {number / (n * n), number / n % n, number % n};
    const Vec3d x = {index[0] * domain.dx(), index[1] * domain.dx(), index[2] * domain.dx()};
    Vec3d& u = grid.velocity[a];
    for (const Collider& c : domain.colliders) u = apply_contact(c, locate(c, x), u);
    for (int axis = 0; axis < 3; ++axis) {
      if (index[axis] <= domain.wall_cells) u[axis] = std::max(u[axis], 0.0);
      if (index[axis] >= domain.n - domain.wall_cells) u[axis] = std::min(u[axis], 0.0);
    }
  }
}

void g2p(const StepperSetup& setup, const std::vector<Grid>& grids, State& state) {
  const double dx = setup.domain.dx();
  for (size_t q = 0; q < state.size(); ++q) {
    const Grid& grid = grids[setup.contact.of(setup.row[q])];
    Vec3d v = {0, 0, 0};
    Mat3d moment = diagonal(0.0, 0.0, 0.0);  // Σ w u (x_a − x_q)ᵀ
    for_each_node(grid, dx, state.x[q], [&](int a, double w, const Vec3d& offset) {
      v = v + w * grid.velocity[a];
      for (int i = 0; i < 3; ++i) moment[i] = moment[i] + (w * grid.velocity[a][i]) * offset;
    });
    state.v[q] = v;
    state.C[q] = (4 / (dx * dx)) * moment;
  }
}

std::vector<Increment> enforce_actions(const StepperSetup& setup, const std::vector<Control>& controls, State& state) {
  std::vector<Increment> increments(state.size());
  for (size_t q = 0; q < state.size(); ++q) {
    const Control& c = controls[setup.control_group[q]];
    const Increment field = field_at(c, state.x[q]);
    const Control::Weight enforced = {c.blend.along == 1 ? 1.0 : 0.0, c.blend.across == 1 ? 1.0 : 0.0};
    Vec3d& v = state.v[q];
    Mat3d& C = state.C[q];
    v = blended(v, field.velocity, c.axis, enforced);
    C = blended(C, field.gradient, c.axis, enforced);
    const Vec3d wanted = blended(v, field.velocity, c.axis, c.position) - v;
    const double weight = std::max(c.position.along, c.position.across), size = norm(wanted);
    const double scale = weight > 0 && size > weight * c.speed_limit ? weight * c.speed_limit / size : 1;
    increments[q] = {scale * wanted, scale * (blended(C, field.gradient, c.axis, c.position) - C)};
  }
  return increments;
}

void move(const StepperSetup& setup, const std::vector<Increment>& increments, double dt, State& state) {
  const double low = kSafeCells * setup.domain.dx(), high = setup.domain.length - low;
  for (size_t q = 0; q < state.size(); ++q) {
    const Vec3d v = state.v[q] + increments[q].velocity;
    const Mat3d gradient = state.C[q] + increments[q].gradient;
    for (int a = 0; a < 3; ++a) state.x[q][a] = std::min(std::max(state.x[q][a] + dt * v[a], low), high);
    state.F[q] = state.F[q] + dt * (gradient * state.F[q]);
    if (setup.track_total_F) state.total_F[q] = state.total_F[q] + dt * (gradient * state.total_F[q]);
  }
}

void return_map(const StepperSetup& setup, double dt, State& state) {
  for (size_t q = 0; q < state.size(); ++q) {
    const Branch branch = branch_of(setup, q);
    if (!has_return_map(branch)) continue;
    update_hencky_by_svd(branch, setup.parameters_of(q), dt, state.F[q], state.strength[q]);
  }
}

void substep(const StepperSetup& setup, const std::vector<Control>& controls, double dt, State& state) {
  blend_actions(setup, controls, state);
  std::vector<Grid> grids;
  for (int body = 0; body < setup.contact.bodies(); ++body) {
    grids.push_back(p2g(setup, state, dt, body));
    grid_update(setup.domain, dt, grids.back());
  }
  meet(setup, grids);
  for (Grid& grid : grids) contact(setup.domain, grid);
  g2p(setup, grids, state);
  const std::vector<Increment> increments = enforce_actions(setup, controls, state);
  move(setup, increments, dt, state);
  return_map(setup, dt, state);
}

}  // namespace physmas::mpm::reference
