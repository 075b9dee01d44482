// The explicit time integration between two output frames, in one precision. Internal to the solver: simulation.h is
// what tools use.
#ifndef PHYSMAS_MPM_STEPPER_H
#define PHYSMAS_MPM_STEPPER_H

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/team.h"
#include "mpm/action/control.h"
#include "mpm/domain.h"
#include "mpm/energy_budget.h"
#include "mpm/material/material.h"
#include "mpm/state.h"

namespace physmas::mpm {

enum class Precision { single, full };

// Everything that stays the same during a run.
struct StepperSetup {
  Domain domain;
  std::vector<Branch> branches;                        // per row
  std::vector<MaterialParameters<double>> parameters;  // per row
  std::vector<int> row;                                // per particle
  std::vector<double> volume;                          // per particle [m^3]
  std::vector<std::uint16_t> control_group;            // per particle
  bool track_total_F = false;                          // State::total_F is integrated as well
  Team* team = nullptr;                                // runs the loops; outlives the stepper
  bool measure_steps = false;                          // the energy budget of every substep
};

// `budget`: more substeps than allowed; only AdaptiveStepping reports it.
enum class StepFault { none, not_finite, speed, energy, budget };

// What was seen during the substeps of one interval.
struct StepReport {
  int steps = 0;  // substeps done, the faulty one included
  StepFault fault = StepFault::none;
  double max_speed = 0;             // fastest particle in any substep [m/s]
  double control_work = 0;          // kinetic and elastic energy that the controls put in, positive parts [J]
  long long particles_clamped = 0;  // most particles held at the edge of the grid in one substep
  int sorts = 0;
  EnergyBudget energy;                                               // when measured
  double seconds_particles = 0, seconds_grid = 0, seconds_sort = 0;  // wall clock
};

class Stepper {
 public:
  virtual ~Stepper() = default;
  // Takes over a state. Positions outside the safe interior are put on its edge; the number of them is returned.
  virtual long long load(const State& state) = 0;
  virtual void store(State& state) const = 0;

  // Substep `step` of the interval, counted from 0: fills the groups' controls, returns false when all are idle.
  using ControlSource = std::function<bool(int step, std::vector<Control>& out)>;
  // Advances by `steps` substeps of dt. Ends early with a fault when a particle's velocity is not finite, when it would
  // cross more than one cell in a substep, or when the kinetic energy exceeds energy_limit + 2 × the controls' work
  // [J].
  virtual StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) = 0;

  virtual int active_grid_blocks() const = 0;
  // Memory of the particles, and of the active grid nodes, in the solver's own order and precision.
  virtual size_t particle_bytes() const = 0;
  virtual size_t grid_bytes() const = 0;
};

std::unique_ptr<Stepper> make_stepper(Precision precision, const StepperSetup& setup);

// Total elastic energy [J] and the range of det F, over all particles, independent of the number of threads.
struct ElasticSummary {
  double energy = 0;
  double recoverable = 0;  // the part of it that has a potential (Jelly, Metal, Foam)
  double min_J = 1, max_J = 1;
};
ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state);

}  // namespace physmas::mpm

#endif
