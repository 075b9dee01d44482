// The fixed problems of the accuracy study.
#ifndef PHYSMAS_STUDIES_ACCURACY_CASES_H
#define PHYSMAS_STUDIES_ACCURACY_CASES_H

#include <string>
#include <vector>

#include "mpm/simulation.h"

namespace physmas::studies {

constexpr double kFloor = 0.5;  // m, a plane of nodes of every grid of the studies

// A box of 2 m without particles; with gravity and a floor of friction 0.5 at kFloor, or neither.
mpm::Problem study_scene(const std::vector<mpm::Material>& materials, bool on_floor);

struct AccuracyCase {
  std::string name;      // jelly-drop
  std::string text;      // one sentence
  mpm::Problem problem;  // the grid's n is set by the study
  double size = 0;       // m: longest edge of an object, which errors are normalised by
  double duration = 0;   // s
};

// Jelly drop, plasticine press, sand collapse, two-object impact, stiff support under a soft body. spacing [m]: of the
// particles, on a lattice that is not aligned with any grid.
std::vector<AccuracyCase> accuracy_cases(double spacing);

// Every particle replaced by k³ on the lattice of spacing / k around it, with an equal part of its volume. Particle i
// becomes k³ i … k³ i + k³ - 1, whose mean is where particle i is.
mpm::Problem subdivide(const mpm::Problem& problem, double spacing, int k = 2);
// Back from places of the subdivided particles: the means of `children` at a time.
std::vector<mpm::Vec3d> means_of_children(const std::vector<mpm::Vec3d>& x, size_t children);

}  // namespace physmas::studies

#endif
