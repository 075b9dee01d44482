// The stability study: every case with every step rule in both precisions, judged from outside the solver.
#ifndef PHYSMAS_STUDIES_STABILITY_H
#define PHYSMAS_STUDIES_STABILITY_H

#include <functional>
#include <string>
#include <vector>

#include "studies/stability_cases.h"

namespace physmas::studies {

// A surplus of total energy above this share of what may move is energy from nowhere.
constexpr double kEnergyFromNowhere = 0.25;

// The step that the paper's rule gives to a problem with these materials [s].
using PaperStep = std::function<double(const std::vector<mpm::Material>&)>;

// One run of one case.
struct StabilityRun {
  std::string study, name, rule, precision;  // rule: "paper" or "cfl"
  std::string branch;                        // of the first material, as E [Pa], nu and rho [kg/m³]
  double E = 0, nu = 0, rho = 0;
  bool stable = false;
  std::string reason;             // of a divergence
  long long first_bad_step = -1;  // of a divergence
  long long late = 0;             // substeps from the first surplus of total energy to first_bad_step
  long long steps = 0;
  double dt = 0, smallest_dt = 0, largest_dt = 0;  // s
  long long retries = 0;
  double limit = 0;  // s, stable_limit of the stiffest row at rest
  double min_J = 1, max_J = 1;
  double surplus = 0;     // largest total energy above that at the start, as a share of what may move
  double apart = 0;       // cells, root mean square distance of particles from the case by cfl in double, at the end
  long long outside = 0;  // particles that the edge of the grid had to hold
  std::string garbage;    // what an outside look finds wrong with a run that calls itself stable; empty: nothing
};

// Runs every case with both rules in both precisions, as many at a time as the device has threads. progress(done,
// total) is called now and then, by any thread. The result does not depend on the threads.
std::vector<StabilityRun> run_stability(const std::vector<StabilityCase>& cases, const PaperStep& paper_step,
                                        const Device& device, const std::function<void(long, long)>& progress);

}  // namespace physmas::studies

#endif
