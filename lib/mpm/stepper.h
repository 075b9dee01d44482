// The explicit time integration between two output frames, by a back end in one precision. Internal to the solver:
// simulation.h is what tools use.
#ifndef PHYSMAS_MPM_STEPPER_H
#define PHYSMAS_MPM_STEPPER_H

#include <functional>
#include <memory>
#include <vector>

#include "base/device.h"
#include "mpm/action/control.h"
#include "mpm/energy_budget.h"
#include "mpm/rigid/rigid_motion.h"
#include "mpm/state.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm {

enum class Precision { single, full };

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
  bool impact = false;      // the next substep runs rigid bodies into something; they are to be let go for it
  std::vector<Vec3d> push;  // per rigid body that is let go: the impulse of contact [kg m/s]
  EnergyBudget energy;      // when measured
  double seconds_particles = 0, seconds_grid = 0, seconds_sort = 0;  // wall clock
};

// Elastic energy [J] and the range of det F, over all particles.
struct ElasticSummary {
  double energy = 0;
  double recoverable = 0;  // the part of it that has a potential (Jelly, Metal, Foam)
  double min_J = 1, max_J = 1;
};

// What bounds the step of one state.
struct StepBounds {
  double wave = 0;      // s: largest stable step, min over particles of dx √(ρ/a), a from stiffness.h
  double speed = 0;     // m/s: fastest particle
  double gradient = 0;  // 1/s: largest Frobenius norm of a velocity gradient
};

// What a stepper uses of the machine; for reports only.
struct StepperUsage {
  int threads = 1;
  double grid_share = 0;                      // 0..1: part of the grid that holds material now
  size_t particle_bytes = 0, grid_bytes = 0;  // of the particles, and of that part of the grid
};

// A back end. What it returns does not depend on its threads, byte for byte.
class Stepper {
 public:
  virtual ~Stepper() = default;
  // Takes over a state. Positions outside the safe interior are put on its edge; the number of them is returned.
  virtual long long load(const State& state) = 0;
  // Only looks: what comes after does not depend on it.
  virtual void store(State& state) const = 0;

  // Substep `step` of the interval, counted from 0: fills the groups' controls, returns false when all are idle.
  using ControlSource = std::function<bool(int step, std::vector<Control>& out)>;
  // Advances by `steps` substeps of dt. Ends early with a fault when a particle's velocity is not finite, when it would
  // cross more than one cell in a substep, or when the kinetic energy exceeds energy_limit + 2 × the controls' work
  // [J].
  virtual StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) = 0;

  // Of any state of the setup's particles, in double precision.
  virtual ElasticSummary summarise_elastic(const State& state) = 0;
  virtual StepBounds measure_bounds(const State& state) = 0;

  virtual StepperUsage usage() const = 0;

  // The setup's rigid bodies, which are held from the first load on; null: this back end has none. `hold` false lets
  // them go, so that they deform as their material does, true takes them up again as they are then.
  virtual RigidMotion* rigid() { return nullptr; }
  virtual void hold(bool /*rigid*/) {}
};

// Throws a usage error (exit code 2) for a device that is not there.
std::unique_ptr<Stepper> make_stepper(const Device& device, Precision precision, const StepperSetup& setup);

}  // namespace physmas::mpm

#endif
