#include <cmath>

#include "base/error.h"
#include "mpm/simulation.h"

namespace physmas::mpm {

namespace {

[[noreturn]] void refuse(const std::string& field, const std::string& found, const std::string& expected) {
  throw invalid_input({"", field, found, expected});
}

bool finite(const Vec3d& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

void check_material(const Material& m, const std::string& where) {
  if (!(m.E > 0) || !std::isfinite(m.E)) refuse(where + "E", std::to_string(m.E), "a positive modulus");
  if (!(m.nu > -1 && m.nu < 0.5)) refuse(where + "nu", std::to_string(m.nu), "above -1 and below 0.5");
  if (!(m.rho > 0) || !std::isfinite(m.rho)) refuse(where + "rho", std::to_string(m.rho), "a positive density");
}

}  // namespace

void check_problem(const Problem& p, const Timing& t) {
  const Domain& d = p.domain;
  if (d.n < 8) refuse("grid n", std::to_string(d.n), "at least 8 cells");
  if (!(d.length > 0) || !std::isfinite(d.length)) refuse("grid length", std::to_string(d.length), "a positive length");
  if (d.wall_cells < 2 || 2 * d.wall_cells >= d.n)
    refuse("wall cells", std::to_string(d.wall_cells), "2 up to half of the grid");
  if (!finite(d.gravity)) refuse("gravity", "a value that is not finite", "three finite numbers");
  if (t.frames < 1) refuse("frames", std::to_string(t.frames), "at least 1");
  if (t.substeps < 1) refuse("substeps", std::to_string(t.substeps), "at least 1");
  if (!(t.frame_dt > 0) || !std::isfinite(t.frame_dt))
    refuse("frame_dt", std::to_string(t.frame_dt), "a positive time");
  for (size_t r = 0; r < p.materials.size(); ++r) check_material(p.materials[r], "material " + std::to_string(r) + " ");
  if (!p.contact.body.empty() && p.contact.body.size() != p.materials.size())
    refuse("bodies", std::to_string(p.contact.body.size()) + " entries", "one per material, or none");
  for (const int body : p.contact.body) {
    if (body < 0 || body >= kMostBodies)
      refuse("body", std::to_string(body), "0 to " + std::to_string(kMostBodies - 1));
  }
  if (!(p.contact.friction >= 0) || !std::isfinite(p.contact.friction))
    refuse("friction between bodies", std::to_string(p.contact.friction), "a number that is not negative");
  const Particles& q = p.particles;
  const size_t count = q.size();
  const auto fits = [&](size_t size) { return size == 0 || size == count; };
  if (q.volume.size() != count || q.row.size() != count || !fits(q.velocity.size()) ||
      !fits(q.deformation_gradient.size()) || !fits(q.material.size()))
    refuse("particles", "arrays of different lengths", "one entry per particle in each");
  for (size_t i = 0; i < count; ++i) {
    const std::string where = "particle " + std::to_string(i) + " ";
    if (!finite(q.position[i])) refuse(where + "position", "a value that is not finite", "three finite numbers");
    if (!(q.volume[i] > 0) || !std::isfinite(q.volume[i]))
      refuse(where + "volume", std::to_string(q.volume[i]), "a positive volume");
    if (q.row[i] < 0 || q.row[i] >= static_cast<int>(p.materials.size()))
      refuse(where + "row", std::to_string(q.row[i]), "an index into the materials");
    if (!q.velocity.empty() && !finite(q.velocity[i]))
      refuse(where + "velocity", "a value that is not finite", "three finite numbers");
    if (!q.material.empty()) check_material(q.material[i], where);
    if (q.deformation_gradient.empty()) continue;
    for (const Vec3d& row : q.deformation_gradient[i].row)
      if (!finite(row)) refuse(where + "F", "a value that is not finite", "nine finite numbers");
  }
}

}  // namespace physmas::mpm
