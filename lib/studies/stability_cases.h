// The problems of the stability study: small scenes that move hard, over the whole range of materials, and extremes.
#ifndef PHYSMAS_STUDIES_STABILITY_CASES_H
#define PHYSMAS_STUDIES_STABILITY_CASES_H

#include <string>
#include <vector>

#include "mpm/simulation.h"

namespace physmas::studies {

struct StabilityCase {
  std::string study;       // "sweep", "labels", "transforms" or "extremes"
  std::string name;        // what it is, unique within the study with the material
  mpm::Problem problem;    // its first material is the one that tables and maps show
  double duration = 0.25;  // s
  int frames = 11;         // output frames, at which the judge looks
};

// All cases, in a fixed order. quick: a subset of some dozens that takes seconds.
std::vector<StabilityCase> stability_cases(bool quick);

// Axes of the sweep.
const std::vector<double>& swept_E();    // Pa
const std::vector<double>& swept_nu();   //
const std::vector<double>& swept_rho();  // kg/m^3

// Grid spacing of all cases [m]: the paper's.
double stability_dx();

// Largest stable step of a material at rest [s], dx [m]: dx √(ρ / max(3κ, 2μ)) (docs/numerics.md).
double stable_limit(const mpm::Material& material, double dx);

}  // namespace physmas::studies

#endif
