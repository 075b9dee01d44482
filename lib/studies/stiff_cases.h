// Scenes with rows too stiff for the step, for `pm-eval stiff`.
#ifndef PHYSMAS_STUDIES_STIFF_CASES_H
#define PHYSMAS_STUDIES_STIFF_CASES_H

#include <string>
#include <vector>

#include "mpm/simulation.h"

namespace physmas::studies {

struct StiffCase {
  std::string name, text;
  mpm::Problem problem;
  double duration = 0;     // s
  std::vector<int> stiff;  // rows
  bool held_out = false;   // chosen before it was run, and nothing tuned on it
  // Largest position errors that are aimed at [share of the row's size], of stiff and of other rows; 0: none.
  double goal_stiff = 0, goal_other = 0;
};

// The material of the stiff rows: E [Pa], 2,000 kg/m^3; all else has 1e5 Pa. A grid of 50 cells of 0.02 m.
std::vector<StiffCase> stiff_cases(double youngs_modulus);

// The same with stiff rows as soft as all else: what the cost is compared with.
StiffCase all_soft(StiffCase stiff);

}  // namespace physmas::studies

#endif
