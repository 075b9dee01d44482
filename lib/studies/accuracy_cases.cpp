#include "studies/accuracy_cases.h"

#include "studies/verification_cases.h"

namespace physmas::studies {
namespace {

using mpm::Problem;
using mpm::Vec3d;

AccuracyCase jelly_drop(double h) {
  AccuracyCase c{"jelly-drop", "A Jelly cube of 0.3 m, 50 kPa, falls 0.08 m onto a rough floor.", {}, 0.3, 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 5e4, 0.3, 1000}}, true);
  seed(c.problem, {0.853, 0.847, kFloor + 0.08}, {1.153, 1.147, kFloor + 0.38}, h, 0);
  return c;
}

AccuracyCase plasticine_press(double h) {
  AccuracyCase c{"plasticine-press",
                 "The top fifth of a Plasticine block, 200 kPa, moves down at 0.4 m/s for 0.2 s, then lets go.",
                 {},
                 0.34,
                 0.3};
  c.problem = study_scene({{mpm::Branch::plasticine, 2e5, 0.3, 1500}}, true);
  seed(c.problem, {0.833, 0.827, kFloor}, {1.173, 1.167, kFloor + 0.24}, h, 0);
  c.problem.schedule.actions.push_back(mpm::TopPress{{0}, {0, 0, -0.4}, {0, 0, 1}, 0.2, 0, 0.2});
  return c;
}

AccuracyCase sand_collapse(double h) {
  AccuracyCase c{
      "sand-collapse", "A cylinder of Sand, 0.3 m wide and 0.25 m high, collapses on a rough floor.", {}, 0.3, 0.5};
  c.problem = study_scene({{mpm::Branch::sand, 5e5, 0.3, 1600}}, true);
  const Vec3d axis = {1.003, 0.997, 0};
  seed(c.problem, {axis.x - 0.15, axis.y - 0.15, kFloor}, {axis.x + 0.15, axis.y + 0.15, kFloor + 0.25}, h, 0,
       [&](const Vec3d& x) { return std::hypot(x.x - axis.x, x.y - axis.y) < 0.15; });
  return c;
}

AccuracyCase two_object_impact(double h) {
  AccuracyCase c{"two-object-impact",
                 "A Jelly ball of 0.3 m, 100 kPa, at 1.5 m/s meets a Metal ball at rest, 500 kPa, off centre.",
                 {},
                 0.3,
                 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 1e5, 0.3, 1000}, {mpm::Branch::metal, 5e5, 0.3, 2000}}, false);
  const Vec3d centers[] = {{0.803, 0.997, 0.75}, {1.203, 1.003, 0.85}};
  for (int row = 0; row < 2; ++row) {
    const Vec3d m = centers[row], edge = {0.15, 0.15, 0.15};
    seed(c.problem, m - edge, m + edge, h, row, [&](const Vec3d& x) { return norm(x - m) < 0.15; });
  }
  for (size_t i = 0; i < c.problem.particles.size(); ++i) {
    if (c.problem.particles.row[i] == 0) c.problem.particles.velocity[i] = {1.5, 0, 0};
  }
  return c;
}

AccuracyCase soft_on_stiff(double h) {
  AccuracyCase c{"soft-on-stiff",
                 "A Jelly block, 20 kPa, falls 0.15 m onto a Metal plate of 10 MPa that lies on the floor.",
                 {},
                 0.4,
                 0.4};
  c.problem = study_scene({{mpm::Branch::metal, 1e7, 0.35, 2500}, {mpm::Branch::jelly, 2e4, 0.35, 800}}, true);
  seed(c.problem, {0.803, 0.797, kFloor}, {1.203, 1.197, kFloor + 0.085}, h, 0);
  seed(c.problem, {0.883, 0.877, kFloor + 0.235}, {1.123, 1.117, kFloor + 0.475}, h, 1);
  return c;
}

}  // namespace

Problem study_scene(const std::vector<mpm::Material>& materials, bool on_floor) {
  Problem p;
  p.domain.gravity = {0, 0, on_floor ? -9.8 : 0};
  p.materials = materials;
  if (on_floor) {
    mpm::Collider floor;
    floor.center = {0, 0, kFloor};
    floor.friction = 0.5;
    p.domain.colliders.push_back(floor);
  }
  return p;
}

std::vector<AccuracyCase> accuracy_cases(double h) {
  return {jelly_drop(h), plasticine_press(h), sand_collapse(h), two_object_impact(h), soft_on_stiff(h)};
}

Problem subdivide(const Problem& problem, double spacing, int k) {
  Problem fine = problem;
  fine.particles = {};
  const mpm::Particles& coarse = problem.particles;
  const auto offset = [&](int j) { return ((j + 0.5) / k - 0.5) * spacing; };
  for (size_t i = 0; i < coarse.size(); ++i) {
    for (int j = 0; j < k * k * k; ++j) {
      fine.particles.position.push_back(coarse.position[i] +
                                        Vec3d{offset(j / (k * k)), offset(j / k % k), offset(j % k)});
      fine.particles.volume.push_back(coarse.volume[i] / (k * k * k));
      fine.particles.row.push_back(coarse.row[i]);
      fine.particles.velocity.push_back(coarse.velocity[i]);
    }
  }
  return fine;
}

std::vector<Vec3d> means_of_children(const std::vector<Vec3d>& x, size_t children) {
  std::vector<Vec3d> mean(x.size() / children, {0, 0, 0});
  for (size_t i = 0; i < x.size(); ++i)
    mean[i / children] = mean[i / children] + (1.0 / static_cast<double>(children)) * x[i];
  return mean;
}

}  // namespace physmas::studies
