// Totals of a state, and how well energies add up from frame to frame.
#ifndef PHYSMAS_MPM_BALANCE_H
#define PHYSMAS_MPM_BALANCE_H

#include <vector>

#include "mpm/energy_budget.h"
#include "mpm/state.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm {

// Totals over all particles at an output frame.
struct Balance {
  int frame = 0;
  double time = 0;                     // s
  double mass = 0;                     // kg
  double kinetic = 0;                  // J, particle velocities only
  double affine = 0;                   // J, kinetic energy of the affine fields of APIC
  double elastic = 0;                  // J; trial energy for Sand, Snow and Plasticine; 0 when not measured
  double recoverable = 0;              // J, the part of it in rows that have a potential: Jelly, Metal and Foam
  double gravity = 0;                  // J, relative to the origin of solver space
  double control_work = 0;             // J put in by actions and projections since the start (positive parts)
  Vec3d momentum = {0, 0, 0};          // kg m/s
  Vec3d angular_momentum = {0, 0, 0};  // kg m^2/s about the origin, the affine part of APIC included
  double max_speed = 0;                // m/s
  double min_J = 1, max_J = 1;         // det F; 1 when not measured
  long long at_wall = 0;               // particles whose stencil reaches a wall node
  EnergyBudget budget;                 // sums since the start; zero unless substeps are measured

  double energy() const { return kinetic + affine + elastic + gravity; }  // J
};

// The totals of a state; what only a stepper measures is left at its defaults.
Balance measure_balance(const StepperSetup& setup, const State& state);

// How well the energies of a run add up.
struct EnergyResidual {
  bool measured = false;  // false: no elastic energy was measured
  bool per_step = false;
  // per_step: largest |residual| of the budget at an output frame: what no measured term explains.
  // Otherwise: the largest rise of the total energy above an earlier frame beyond the work of controls in between:
  // energy from nowhere, at least; losses cannot be told from dissipation.
  double joules = 0;
  double scale = 0;  // J: largest kinetic + elastic energy, or change of the energy of gravity, at an output frame
};

// Total energy may only fall between output frames, but for what controls put in. An unstable step can also saturate
// at a few times the energy of the motion, below the limit of the substeps' own check: this finds it at the next frame.
// Rows whose stress has no potential count with their kinetic energy and their weight only; what they store at the
// start may all come back.
class EnergyWatch {
 public:
  // scale [J]: energy that may move besides a change of height.
  EnergyWatch(const Balance& start, double scale) : start_(start), scale_(scale) {}
  bool surplus(const Balance& b);

 private:
  Balance start_;
  double scale_, fall_ = 0;
};

}  // namespace physmas::mpm

#endif
