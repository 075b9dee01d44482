#include "studies/error_cases.h"

#include <cmath>

#include "studies/verification_cases.h"

namespace physmas::studies {
namespace {

using mpm::Problem;
using mpm::Vec3d;

void seed_ball(Problem& p, const Vec3d& center, double radius, double h, int row) {
  const Vec3d edge = {radius, radius, radius};
  seed(p, center - edge, center + edge, h, row, [&](const Vec3d& x) { return norm(x - center) < radius; });
}

AccuracyCase rolling_ball(double h) {
  AccuracyCase c{
      "rolling-ball", "A Jelly ball of 0.3 m, 200 kPa, is pushed along a rough floor at 0.8 m/s.", {}, 0.3, 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 2e5, 0.35, 1000}}, true);
  seed_ball(c.problem, {0.703, 0.997, kFloor + 0.15}, 0.15, h, 0);
  for (Vec3d& v : c.problem.particles.velocity) v = {0.8, 0, 0};
  return c;
}

AccuracyCase cantilever(double h) {
  AccuracyCase c{
      "cantilever", "A Jelly beam of 0.6 x 0.15 x 0.15 m, 300 kPa, held at one end, sags under gravity.", {}, 0.6, 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 3e5, 0.3, 1000}}, true);
  seed(c.problem, {0.703, 0.923, 0.947}, {1.303, 1.073, 1.097}, h, 0);
  c.problem.schedule.actions.push_back(mpm::SlabMotion{{0}, {0, 0, 0}, {-1, 0, 0}, 0.25, 0, 1});
  return c;
}

AccuracyCase tower(double h) {
  AccuracyCase c{
      "tower", "A soft, a stiff and a soft block on one another are let go 0.05 m above a rough floor.", {}, 0.46, 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 5e4, 0.3, 900}, {mpm::Branch::metal, 2e6, 0.3, 2000}}, true);
  seed(c.problem, {0.873, 0.867, kFloor + 0.05}, {1.113, 1.107, kFloor + 0.21}, h, 0);
  seed(c.problem, {0.893, 0.887, kFloor + 0.21}, {1.093, 1.087, kFloor + 0.33}, h, 1);
  seed(c.problem, {0.913, 0.907, kFloor + 0.33}, {1.073, 1.067, kFloor + 0.51}, h, 0);
  return c;
}

AccuracyCase snowball(double h) {
  AccuracyCase c{"snowball", "A ball of Snow of 0.28 m, 200 kPa, hits a rough floor at 3 m/s.", {}, 0.28, 0.2};
  c.problem = study_scene({{mpm::Branch::snow, 2e5, 0.25, 400}}, true);
  seed_ball(c.problem, {1.003, 0.997, kFloor + 0.2}, 0.14, h, 0);
  for (Vec3d& v : c.problem.particles.velocity) v = {0, 0, -3};
  return c;
}

AccuracyCase ball_on_cushion(double h) {
  AccuracyCase c{
      "ball-on-cushion", "A Metal ball of 0.2 m, 2 MPa, falls 0.1 m onto a Foam cushion of 30 kPa.", {}, 0.44, 0.4};
  c.problem = study_scene({{mpm::Branch::foam, 3e4, 0.2, 200}, {mpm::Branch::metal, 2e6, 0.3, 1500}}, true);
  seed(c.problem, {0.783, 0.777, kFloor}, {1.223, 1.217, kFloor + 0.17}, h, 0);
  seed_ball(c.problem, {1.013, 0.987, kFloor + 0.37}, 0.1, h, 1);
  return c;
}

AccuracyCase twisted_bar(double h) {
  AccuracyCase c{
      "twisted-bar",
      "The upper fifth of a Metal bar of 0.2 x 0.2 x 0.5 m, 1 MPa, on the floor is turned at 3 rad/s for 0.25 s.",
      {},
      0.5,
      0.4};
  c.problem = study_scene({{mpm::Branch::metal, 1e6, 0.3, 1200}}, true);
  seed(c.problem, {0.903, 0.897, kFloor}, {1.103, 1.097, kFloor + 0.5}, h, 0);
  mpm::Torque turn;
  turn.rows = {0};
  turn.rate = 3;
  turn.slab_fraction = 0.2;
  turn.end = 0.25;
  turn.enforced = true;
  c.problem.schedule.actions.push_back(turn);
  return c;
}

AccuracyCase dropped_sand(double h) {
  AccuracyCase c{"dropped-sand", "A block of Sand, 1 MPa, falls 0.1 m onto a rough floor.", {}, 0.28, 0.4};
  c.problem = study_scene({{mpm::Branch::sand, 1e6, 0.25, 1500}}, true);
  seed(c.problem, {0.863, 0.857, kFloor + 0.1}, {1.143, 1.137, kFloor + 0.3}, h, 0);
  return c;
}

AccuracyCase pressed_snow(double h) {
  AccuracyCase c{"pressed-snow",
                 "The top fifth of a block of Snow, 300 kPa, moves down at 0.3 m/s for 0.2 s, then lets go.",
                 {},
                 0.32,
                 0.3};
  c.problem = study_scene({{mpm::Branch::snow, 3e5, 0.2, 350}}, true);
  seed(c.problem, {0.843, 0.837, kFloor}, {1.163, 1.157, kFloor + 0.25}, h, 0);
  c.problem.schedule.actions.push_back(mpm::TopPress{{0}, {0, 0, -0.3}, {0, 0, 1}, 0.2, 0, 0.2});
  return c;
}

AccuracyCase thrown_cross(double h) {
  AccuracyCase c{
      "thrown-cross", "A Jelly cross of two bars, 150 kPa, is thrown at a rough floor and turns.", {}, 0.44, 0.4};
  c.problem = study_scene({{mpm::Branch::jelly, 1.5e5, 0.35, 1000}}, true);
  const Vec3d m = {0.953, 0.997, kFloor + 0.33};
  seed(c.problem, m - Vec3d{0.22, 0.22, 0.22}, m + Vec3d{0.22, 0.22, 0.22}, h, 0, [&](const Vec3d& x) {
    const Vec3d r = x - m;
    return std::fabs(r.y) < 0.07 && (std::fabs(r.x) < 0.07 || std::fabs(r.z) < 0.07);
  });
  mpm::Particles& p = c.problem.particles;
  for (size_t i = 0; i < p.size(); ++i) {
    const Vec3d r = p.position[i] - m;
    p.velocity[i] = {0.6 + 3 * r.z, 0, -1 - 3 * r.x};
  }
  return c;
}

AccuracyCase falling_slab(double h) {
  AccuracyCase c{
      "falling-slab", "A Metal slab, 1 MPa, tips over an edge on a rough floor onto a Plasticine block.", {}, 0.5, 0.4};
  c.problem = study_scene({{mpm::Branch::metal, 1e6, 0.3, 1200}, {mpm::Branch::plasticine, 1e5, 0.3, 1200}}, true);
  seed(c.problem, {0.703, 0.897, kFloor}, {0.803, 1.097, kFloor + 0.5}, h, 0);
  seed(c.problem, {1.003, 0.897, kFloor}, {1.203, 1.097, kFloor + 0.17}, h, 1);
  mpm::Particles& p = c.problem.particles;
  for (size_t i = 0; i < p.size(); ++i) {
    if (p.row[i] == 0) p.velocity[i] = {3 * (p.position[i].z - kFloor), 0, -3 * (p.position[i].x - 0.803)};
  }
  return c;
}

}  // namespace

std::vector<AccuracyCase> further_cases(double h) {
  return {rolling_ball(h), cantilever(h), tower(h), snowball(h), ball_on_cushion(h), twisted_bar(h)};
}

std::vector<AccuracyCase> held_out_cases(double h) {
  return {dropped_sand(h), pressed_snow(h), thrown_cross(h), falling_slab(h)};
}

}  // namespace physmas::studies
