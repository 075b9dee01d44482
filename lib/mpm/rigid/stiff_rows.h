// Which rows are too stiff for the step, and what becomes of them.
#ifndef PHYSMAS_MPM_RIGID_STIFF_ROWS_H
#define PHYSMAS_MPM_RIGID_STIFF_ROWS_H

#include <string>
#include <vector>

#include "mpm/action/schedule.h"
#include "mpm/material/material.h"
#include "mpm/rigid/rigid_setup.h"
#include "mpm/state.h"

namespace physmas::mpm {

// off: every row deforms, whatever the step (the paper's letter). rigid: rows whose stable step is below a third of the
// substep keep their shape. automatic: of those, the ones that would hardly bend.
enum class StiffRule { off, rigid, automatic };

// A row whose material allows no step as long as the run's.
struct StiffRow {
  int row = 0;
  bool rigid = false;
  double limit = 0;         // s: its largest stable step
  double deflection = 0;    // estimated bending under its own weight over its length; 0: not estimated
  std::string why;          // one clause, for people
  std::vector<int> bodies;  // of the run, that its particles belong to
};

// Where several rows of one object touch they are one body; where a row consists of pieces they are several.
struct RigidPlan {
  std::vector<StiffRow> rows;
  RigidSetup setup;      // body_of_row counts the rows below
  std::vector<int> row;  // per particle: as the stepper shall have it; a problem's row of several bodies is several
  std::vector<int> source_row;  // per row of the stepper: the problem's
};

// What the plan is made from; the parts outlive the call.
struct StiffProblem {
  double dx = 0;                                              // m
  Vec3d gravity = {0, 0, 0};                                  // m/s^2
  const std::vector<Branch>& branches;                        // per row
  const std::vector<MaterialParameters<double>>& parameters;  // per row
  const std::vector<ParticleElasticity<double>>& elasticity;  // per particle, or empty
  const std::vector<int>& object;                             // per row, or empty: all rows are one object's
  const Particles& particles;
  const std::vector<Action>& actions;
  bool separate_contact = false;  // rows move with several velocity fields already
};

// dt [s]: the substep.
RigidPlan plan_rigid(const StiffProblem& problem, StiffRule rule, double dt);

// Bound of a rigid body's relative error while nothing hits it [1]: what its first bending mode would give way by under
// this acceleration [m/s^2] (a free beam of the body's longest and smallest extent; Euler and Bernoulli). dx [m].
double rigid_error(const RigidBodyRest& rest, double dx, const MaterialParameters<double>& material,
                   double acceleration);

}  // namespace physmas::mpm

#endif
