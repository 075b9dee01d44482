#include "studies/stability_cases.h"

#include <fmt/format.h>

#include <random>

#include "bind/branch.h"

namespace physmas::studies {
namespace {

using mpm::Mat3d;
using mpm::Material;
using mpm::Vec3d;

// The grid spacing is that of the paper's 100³ grid over an edge of 2, so that steps compare with its own.
constexpr double kDx = 0.02;
constexpr int kCells = 16;
constexpr double kFloorHeight = 4.3 * kDx;  // not on a node
constexpr double kEdge = 3 * kDx;           // of the block
constexpr double kGap = kDx;                // that it falls
constexpr double kLongest = 0.25;           // s
constexpr double kTransits = 20;            // of a wave through the block, after the impact
constexpr double kMach = 0.05;              // least impact speed as a share of the wave speed
constexpr double kFastest = 200;            // m/s: half a cell in the smallest step of the paper's rule, 5e-5 s

mpm::Domain make_domain() {
  mpm::Domain domain;
  domain.n = kCells;
  domain.length = kCells * kDx;
  mpm::Collider floor;
  floor.center = {0, 0, kFloorHeight};
  floor.friction = 0.4;
  domain.colliders.push_back(floor);
  return domain;
}

// A block of eight jittered particles per cell, `low` its lowest corner.
void add_block(mpm::Problem& p, const Vec3d& low, const Vec3d& size, int row, const Vec3d& velocity) {
  const double h = kDx / 2;
  std::mt19937 random(7 + row);
  std::uniform_real_distribution<double> jitter(-0.2 * h, 0.2 * h);
  for (int x = 0; (x + 0.5) * h < size.x; ++x)
    for (int y = 0; (y + 0.5) * h < size.y; ++y)
      for (int z = 0; (z + 0.5) * h < size.z; ++z) {
        p.particles.position.push_back({low.x + (x + 0.5) * h + jitter(random), low.y + (y + 0.5) * h + jitter(random),
                                        low.z + (z + 0.5) * h + jitter(random)});
        p.particles.volume.push_back(h * h * h);
        p.particles.row.push_back(row);
        p.particles.velocity.push_back(velocity);
      }
}

void add_particle(mpm::Problem& p, const Vec3d& x, int row, const Vec3d& velocity = {0, 0, 0}) {
  p.particles.position.push_back(x);
  p.particles.volume.push_back(kDx * kDx * kDx / 8);
  p.particles.row.push_back(row);
  p.particles.velocity.push_back(velocity);
}

double impact_speed(const Material& m) {
  return std::min(kFastest, std::max(1.0, kMach * wave_speed(m)));
}

// Shorter where the speed is capped, so that waves cross twenty cells during the fall at most.
double fall_height(const Material& m) {
  return std::min(kGap, impact_speed(m) * kTransits * kDx / wave_speed(m));
}

// Long enough for the fall and for twenty transits; capped where waves are slow.
double impact_duration(const Material& m) {
  return std::min(kLongest, fall_height(m) / impact_speed(m) + kTransits * kEdge / wave_speed(m));
}

Vec3d block_corner(double height = kGap) {
  const double side = 0.5 * (kCells * kDx - kEdge) + 0.13 * kDx;
  return {side, side, kFloorHeight + height};
}

// A block that hits the floor at an edge and a corner first would tumble; here it hits flat, a little askew in x.
StabilityCase falling_block(const std::string& study, const std::string& name, const Material& material) {
  StabilityCase c;
  c.study = study;
  c.name = name;
  c.problem.domain = make_domain();
  c.problem.materials = {material};
  const double speed = impact_speed(material);
  add_block(c.problem, block_corner(fall_height(material)), {kEdge, kEdge, kEdge}, 0, {0.3 * speed, 0, -speed});
  c.duration = impact_duration(material);
  return c;
}

// Two rows, one on top of the other, falling together.
StabilityCase falling_pair(const std::string& study, const std::string& name, const Material& below,
                           const Material& above) {
  StabilityCase c;
  c.study = study;
  c.name = name;
  c.problem.domain = make_domain();
  c.problem.materials = {below, above};
  const Vec3d low = block_corner();
  add_block(c.problem, low, {kEdge, kEdge, kEdge / 2}, 0, {0, 0, -1});
  add_block(c.problem, low + Vec3d{0, 0, kEdge / 2}, {kEdge, kEdge, kEdge / 2}, 1, {0, 0, -1});
  c.duration = std::min(kLongest, 0.02 + kTransits * kEdge / std::max(wave_speed(below), wave_speed(above)));
  return c;
}

void add_sweep(std::vector<StabilityCase>& cases, bool quick) {
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    for (size_t e = 0; e < swept_E().size(); ++e) {
      for (size_t n = 0; n < swept_nu().size(); ++n) {
        for (size_t r = 0; r < swept_rho().size(); ++r) {
          if (quick && (e % 5 != 0 || n % 5 != 2 || r != 1)) continue;
          cases.push_back(falling_block("sweep", "falling block",
                                        {static_cast<mpm::Branch>(b), swept_E()[e], swept_nu()[n], swept_rho()[r]}));
        }
      }
    }
  }
}

// Table "mapping": every label at the four ends of its ranges.
void add_labels(std::vector<StabilityCase>& cases, bool quick) {
  for (const LabelPrior& label : kLabels) {
    for (const double E : {label.E_lo, label.E_hi}) {
      for (const double nu : {label.nu_lo, label.nu_hi}) {
        if (quick && (E == label.E_lo || nu == label.nu_lo)) continue;
        cases.push_back(falling_block("labels", label.name, {bind::bind_branch(label.branch), E, nu, label.rho}));
      }
    }
  }
}

// The rows that the composite transforms of Table "candidatetransforms" and the repairs write (lib/candidate), at both
// ends of what they allow, with the fallback of the whole-object record (5e5 Pa, 0.476, 5000 kg/m³).
void add_transforms(std::vector<StabilityCase>& cases) {
  const Material bonded = {mpm::Branch::plasticine, 5e5, 0.476, 5000};
  const auto block = [&](const char* name, const Material& m) {
    cases.push_back(falling_block("transforms", name, m));
  };
  const auto pair = [&](const char* name, const Material& below, const Material& above) {
    cases.push_back(falling_pair("transforms", name, below, above));
  };
  block("support row, lightest", {mpm::Branch::metal, 1e7, 0.35, 1000});
  block("support row, heaviest", {mpm::Branch::metal, 1e7, 0.05, 3000});
  block("impact target, softest", {mpm::Branch::foam, 2e4, 0.2, 300});
  block("impact target, stiffest", {mpm::Branch::foam, 7.5e4, 0.4, 450});
  block("compatible row, lightest", {mpm::Branch::plasticine, 1.7 * 5e5, 0.485, 100});
  block("compatible row, heaviest", {mpm::Branch::plasticine, 0.85 * 5e5, 0.2, 7800});
  block("elastic cohesion", {mpm::Branch::jelly, 5e5, 0.42, 500});
  block("higher cohesion, sand", {mpm::Branch::sand, 5e5, 0.45, 500});
  pair("hard-support bonded", {mpm::Branch::metal, 1e7, 0.35, 2500}, bonded);
  pair("support-stiff under foam", {mpm::Branch::metal, 1e7, 0.35, 1000}, {mpm::Branch::foam, 1e3, 0.1, 300});
  pair("rigid-support under snow", {mpm::Branch::metal, 1e7, 0.45, 300}, {mpm::Branch::snow, 1e3, 0.1, 300});
  pair("solver-compatible", bonded, {mpm::Branch::plasticine, 0.85 * 5e5, 0.476, 5000});
}

Material typical(int branch) {
  return {static_cast<mpm::Branch>(branch), 1e5, 0.3, 1000};
}

StabilityCase extreme(const std::string& name, const Material& material) {
  StabilityCase c;
  c.study = "extremes";
  c.name = name;
  c.problem.domain = make_domain();
  c.problem.materials = {material};
  return c;
}

void add_few_particles(std::vector<StabilityCase>& cases) {
  const Vec3d above = {8.2 * kDx, 8.4 * kDx, kFloorHeight + 0.7 * kDx};
  const Material stiff = {mpm::Branch::metal, 1e7, 0.3, 1000}, soft = {mpm::Branch::jelly, 1e5, 0.3, 1000};
  StabilityCase c = extreme("one particle", stiff);
  add_particle(c.problem, above, 0, {1, 0, -1});
  cases.push_back(c);
  c = extreme("two coincident particles", soft);
  for (int i = 0; i < 2; ++i) add_particle(c.problem, above, 0, {0.5, 0, -1});
  cases.push_back(c);
  c = extreme("two coincident particles that part", soft);
  for (int i = 0; i < 2; ++i) add_particle(c.problem, above, 0, {i ? 5.0 : -5.0, 0, 0});
  cases.push_back(c);
  c = extreme("particles on cell faces, edges and corners", soft);
  for (int i = 0; i < 8; ++i)
    add_particle(c.problem, {(8 + 0.5 * (i & 1)) * kDx, (8 + 0.5 * (i >> 1 & 1)) * kDx, (6 + 0.5 * (i >> 2)) * kDx}, 0);
  cases.push_back(c);
  c = extreme("particles on the domain wall and on the edge of the grid", soft);
  c.problem.domain.colliders.clear();
  for (const double z : {3.0, 2.0, 0.0}) add_particle(c.problem, {8 * kDx, 8 * kDx, z * kDx}, 0, {0, 0, -3});
  add_particle(c.problem, {13 * kDx, 13 * kDx, 13 * kDx}, 0, {3, 3, 3});
  add_particle(c.problem, {16 * kDx, 16 * kDx, 16 * kDx}, 0, {3, 3, 3});
  cases.push_back(c);
  c = extreme("a row with a single particle inside another", soft);
  c.problem.materials.push_back(stiff);
  add_block(c.problem, block_corner(), {kEdge, kEdge, kEdge}, 0, {0, 0, -1});
  c.problem.particles.row[c.problem.particles.size() / 2] = 1;
  cases.push_back(c);
  c = extreme("no particles", soft);
  cases.push_back(c);
  c = extreme("one frame: the rest frame only", soft);
  add_particle(c.problem, above, 0);
  c.frames = 1;
  cases.push_back(c);
}

void add_thin(std::vector<StabilityCase>& cases) {
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    StabilityCase c = extreme("a sheet thinner than a cell", typical(b));
    for (int x = 0; x < 6; ++x)
      for (int y = 0; y < 6; ++y)
        add_particle(c.problem, {(6.6 + 0.5 * x) * kDx, (6.6 + 0.5 * y) * kDx, kFloorHeight + (0.2 + 0.3 * x) * kDx}, 0,
                     {1, 0, -2});
    cases.push_back(c);
  }
}

void add_deformed(std::vector<StabilityCase>& cases) {
  const std::vector<std::pair<const char*, Mat3d>> starts = {
      {"inverted F", mpm::diagonal(1.0, 1.0, -1.0)},
      {"F inverted in all directions", mpm::diagonal(-1.0, -1.0, -1.0)},
      {"collapsed F: zero", mpm::diagonal(0.0, 0.0, 0.0)},
      {"collapsed F: a plane", mpm::diagonal(1.0, 1.0, 0.0)},
      {"compressed F: 0.3", mpm::diagonal(0.3, 0.3, 0.3)},
      {"stretched F: 3", mpm::diagonal(3.0, 3.0, 3.0)},
      {"sheared F: 5", {{{1, 5, 0}, {0, 1, 0}, {0, 0, 1}}}},
  };
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    for (const auto& [name, F] : starts) {
      StabilityCase c = extreme(name, typical(b));
      add_block(c.problem, block_corner(), {kEdge, kEdge, kEdge}, 0, {0, 0, 0});
      c.problem.particles.deformation_gradient.assign(c.problem.particles.size(), F);
      c.duration = 0.1;
      cases.push_back(c);
    }
  }
}

void add_forced(std::vector<StabilityCase>& cases) {
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    StabilityCase c = falling_block("extremes", "gravity: none", typical(b));
    c.problem.domain.gravity = {0, 0, 0};
    cases.push_back(c);
    c = falling_block("extremes", "gravity: a thousandfold", typical(b));
    c.problem.domain.gravity = {0, 0, -9800};
    cases.push_back(c);
    c = falling_block("extremes", "an impulse that crosses the domain in one frame", typical(b));
    c.problem.schedule.actions.push_back(mpm::Impulse{{0}, {8, 0, 0}, 0.01, 8e-4, 2e-4});
    cases.push_back(c);
    c = falling_block("extremes", "an impulse that crosses the domain in one hundredth of a frame", typical(b));
    c.problem.schedule.actions.push_back(mpm::Impulse{{0}, {800, 0, 0}, 0.001, 8e-4, 2e-4});
    c.duration = 0.01;
    cases.push_back(c);
    c = falling_block("extremes", "pressed flat against the floor", typical(b));
    c.problem.schedule.actions.push_back(mpm::TopPress{{0}, {0, 0, -1}, {0, 0, 1}, 0.3, 0.0, 0.07});
    c.duration = 0.1;
    cases.push_back(c);
  }
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    StabilityCase c = extreme("stiff, hitting the floor at a fifth of its wave speed",
                              {static_cast<mpm::Branch>(b), 3e11, 0.3, 1000});
    const double speed = 0.2 * wave_speed(c.problem.materials[0]);
    add_block(c.problem, block_corner(), {kEdge, kEdge, kEdge}, 0, {0.3 * speed, 0, -speed});
    c.duration = 2 * kGap / speed + kTransits * kEdge / wave_speed(c.problem.materials[0]);
    cases.push_back(c);
  }
  StabilityCase c = falling_pair("extremes", "stiff under soft, ratio 1e8", {mpm::Branch::metal, 1e11, 0.3, 1000},
                                 {mpm::Branch::jelly, 1e3, 0.3, 1000});
  c.duration = 2e-3;
  cases.push_back(c);
  c = falling_pair("extremes", "soft under stiff, ratio 1e8", {mpm::Branch::jelly, 1e3, 0.3, 1000},
                   {mpm::Branch::metal, 1e11, 0.3, 1000});
  c.duration = 2e-3;
  cases.push_back(c);
}

void add_crowd(std::vector<StabilityCase>& cases, int count) {
  StabilityCase c = extreme(fmt::format("{} particles in one cell", count), {mpm::Branch::jelly, 1e5, 0.3, 1000});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> inside(0, kDx);
  for (int i = 0; i < count; ++i) {
    add_particle(c.problem, {8 * kDx + inside(random), 8 * kDx + inside(random), kFloorHeight + inside(random)}, 0,
                 {0, 0, -1});
    c.problem.particles.volume.back() = kDx * kDx * kDx / count;
  }
  c.duration = 0.01;
  c.frames = 3;
  cases.push_back(c);
}

}  // namespace

const std::vector<double>& swept_E() {
  static const std::vector<double> values = {1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 3e11};
  return values;
}

const std::vector<double>& swept_nu() {
  static const std::vector<double> values = {0, 0.2, 0.35, 0.45, 0.49, 0.499};
  return values;
}

const std::vector<double>& swept_rho() {
  static const std::vector<double> values = {50, 1000, 4500, 20000};
  return values;
}

double stability_dx() {
  return kDx;
}

double stable_limit(const Material& material, double dx) {
  return mpm::rest_limit(mpm::derive_parameters(material, {}), dx);
}

std::vector<StabilityCase> stability_cases(bool quick) {
  std::vector<StabilityCase> cases;
  add_sweep(cases, quick);
  add_labels(cases, quick);
  add_transforms(cases);
  add_few_particles(cases);
  if (!quick) add_thin(cases);
  if (!quick) add_deformed(cases);
  if (!quick) add_forced(cases);
  add_crowd(cases, quick ? 20000 : 200000);
  return cases;
}

}  // namespace physmas::studies
