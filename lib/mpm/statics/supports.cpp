#include "mpm/statics/supports.h"

#include <algorithm>

#include "mpm/action/collider.h"

namespace physmas::mpm::statics {

Supports::Supports(const Domain& domain, const ElasticGrid& grid, const std::vector<double>& held_mass)
    : contact_of_(grid.node_count(), -1) {
  for (size_t a = 0; a < grid.node_count(); ++a) {
    Contact c;
    c.node = static_cast<int>(a);
    c.fixed = held_mass[a] > 0 && held_mass[a] >= 0.5 * grid.mass()[a];
    const std::array<int, 3>& place = grid.place(a);
    const Vec3d x = {place[0] * domain.dx(), place[1] * domain.dx(), place[2] * domain.dx()};
    for (const Collider& collider : domain.colliders) {
      const mpm::Contact contact = locate(collider, x);
      if (contact.distance > 0) continue;
      if (collider.mode == Collider::Mode::sticky)
        c.fixed = true;
      else
        add_normal(c, contact.normal, collider.mode == Collider::Mode::slip, collider.friction);
    }
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d inward = {0, 0, 0};
      inward[axis] = place[axis] <= domain.wall_cells ? 1 : place[axis] >= domain.n - domain.wall_cells ? -1 : 0;
      if (inward[axis] != 0) add_normal(c, inward, false, 0);
    }
    if (!c.fixed && c.count == 0) continue;
    c.sticks = c.friction > 0;
    contact_of_[a] = static_cast<int>(contacts_.size());
    contacts_.push_back(c);
  }
}

void Supports::add_normal(Contact& c, const Vec3d& normal, bool pulls, double friction) const {
  c.friction = std::max(c.friction, friction);
  Vec3d n = normal;
  for (int i = 0; i < c.count; ++i) n = n - dot(n, c.normal[i]) * c.normal[i];
  const double length = norm(n);
  if (c.count == 3 || length < 0.1) return;  // held already, as good as
  c.normal[c.count] = (1 / length) * n;
  c.pulls[c.count] = pulls;
  ++c.count;
}

Vec3d Supports::free_part(const Contact& c, Vec3d v) const {
  if (c.fixed) return {0, 0, 0};
  bool open = false;
  for (int i = 0; i < c.count; ++i) {
    open = open || c.open[i];
    if (!c.open[i]) v = v - dot(v, c.normal[i]) * c.normal[i];
  }
  return c.sticks && !open ? Vec3d{0, 0, 0} : v;
}

Vec3d Supports::free_part(size_t node, const Vec3d& v) const {
  return contact_of_[node] < 0 ? v : free_part(contacts_[contact_of_[node]], v);
}

Vec3d Supports::reaction(size_t node, const Vec3d& force) const {
  if (contact_of_[node] < 0) return {0, 0, 0};
  const Contact& c = contacts_[contact_of_[node]];
  return c.drag - (force + c.drag - free_part(c, force + c.drag));
}

void Supports::project(NodeField& field) const {
  for (const Contact& c : contacts_) field[c.node] = to_vec4(free_part(c, to_vec3(field[c.node])));
}

void Supports::add_friction(NodeField& force) const {
  for (const Contact& c : contacts_) force[c.node] += to_vec4(c.drag);
}

int Supports::update(const NodeField& force, const NodeField& u, const std::vector<double>& weight) {
  int changed = 0;
  for (Contact& c : contacts_) {
    if (!c.fixed) changed += update(c, to_vec3(force[c.node]), to_vec3(u[c.node]), weight[c.node]);
  }
  return changed;
}

bool Supports::update(Contact& c, const Vec3d& force, const Vec3d& u, double weight) const {
  constexpr double kSlack = 1e-3;  // of the node's weight
  constexpr int kPatience = 2;     // a node that is let go again and again stays so
  bool changed = false;
  double pressed = 0;
  Vec3d tangential = force;
  for (int i = 0; i < c.count; ++i) {
    const double out = dot(force, c.normal[i]);
    tangential = tangential - out * c.normal[i];
    if (c.open[i]) {
      if (dot(u, c.normal[i]) >= 0 || c.opened[i] >= kPatience) continue;
      c.open[i] = false;
      changed = true;
    } else if (!c.pulls[i] && out > kSlack * weight) {
      c.open[i] = changed = true;
      ++c.opened[i];
    }
    if (!c.open[i]) pressed += std::max(0.0, -out);
  }
  if (c.friction == 0) return changed;
  const double limit = c.friction * pressed, pull = norm(tangential);
  const bool open = std::any_of(c.open, c.open + c.count, [](bool o) { return o; });
  if (c.sticks && !open && pull > (1 + kSlack) * limit + kSlack * weight) {
    c.sticks = false;
    c.along = (-1 / pull) * tangential;
    changed = true;
  }
  c.drag = c.sticks || open ? Vec3d{0, 0, 0} : limit * c.along;
  return changed;
}

}  // namespace physmas::mpm::statics
