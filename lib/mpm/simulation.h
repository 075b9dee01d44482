// The material point solver: what tools call.
//
// Explicit APIC with quadratic B-splines and MLS forces (paper, "Solver-Aware Shared-Domain Simulation"): particles of
// all rows share one grid. `run` owns the whole time loop; frames come out through a callback.
#ifndef PHYSMAS_MPM_SIMULATION_H
#define PHYSMAS_MPM_SIMULATION_H

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/device.h"
#include "mpm/action/schedule.h"
#include "mpm/balance.h"
#include "mpm/body_contact.h"
#include "mpm/domain.h"
#include "mpm/material/material.h"
#include "mpm/rigid/impact_windows.h"
#include "mpm/rigid/stiff_rows.h"
#include "mpm/state.h"
#include "mpm/stepper.h"
#include "mpm/timestep.h"

namespace physmas::mpm {

// One candidate's simulation. Units: m, s, kg, Pa of solver space.
struct Problem {
  Domain domain;
  std::vector<Material> materials;  // per row; rows without particles are allowed
  std::vector<int> object;          // per row, of what it is a part; empty: all are parts of one thing
  BodyContact contact;              // by default all rows are one body
  ProfileConstants constants;
  Particles particles;
  Schedule schedule;
};

// `fixed`: frame_dt / substeps throughout (the paper's rule chooses the number of substeps). `cfl`: timestep.h.
enum class StepRule { fixed, cfl };

struct Timing {
  int frames = 50;         // output frames T, the rest frame 0 included, at least 1
  double frame_dt = 0.04;  // s between output frames
  int substeps = 200;      // per output frame, at least 1; dt = frame_dt / substeps; `cfl`: no larger than that
  StepRule rule = StepRule::fixed;
};

struct Options {
  Precision precision = Precision::single;
  Device device;                     // results do not depend on its threads, byte for byte
  bool track_total_F = false;        // integrate State::total_F = Π (I + dt C), which no return map touches
  bool measure_energy = true;        // elastic energy and the range of det F at output frames
  bool measure_steps = false;        // the energy budget of every substep (much slower); implies measure_energy
  StiffRule stiff = StiffRule::off;  // what becomes of rows too stiff for the step (rigid/stiff_rows.h)
  double impact_budget =
      1;  // of rigid rows: small steps in impacts per substep, below 0: none (rigid/impact_windows.h)
  long long max_steps = 10'000'000;  // a run that needs more ends as `diverged`, reason "budget"
  // Takes the place of make_stepper: for tests of a back end that no device stands for.
  std::function<std::unique_ptr<Stepper>(Precision, const StepperSetup&)> stepper;
};

// Handed to the callback at every output frame, frame 0 first. `state` holds all particles in the callers' order, after
// projections; it is valid during the call only.
struct Frame {
  int index;
  double time;  // s
  const State& state;
};
using FrameCallback = std::function<void(const Frame&)>;

// A part of the solver that a problem does without.
struct Omission {
  std::string what, why;
};
std::vector<Omission> omissions(const Problem& problem, const Options& options);

enum class Status { stable, diverged };

// A rigid body of a run.
struct RigidBodyReport {
  std::vector<int> rows;            // of the problem
  double mass = 0;                  // kg
  long long impacts = 0;            // that no window was left for
  double restitution = -1;          // measured in its windows; -1: none
  double largest_acceleration = 0;  // m/s^2, between impacts
  double largest_jump = 0;          // m/s: of its velocity in one substep
  double error = 0;                 // bound of its bending between impacts, over its length
};

struct Result {
  Status status = Status::stable;
  // Global substep, counted from 0, in which a fault was found; -1 when stable. Every substep checks every particle, so
  // what explodes is found within some substeps; what is too weak for that, at the next output frame.
  long long first_bad_step = -1;
  std::string reason;  // "", "nan" (not finite), "speed" (over a cell per substep), "energy" (more than can be there),
                       // "budget" (more than max_steps), "step" (far above the limit of the material)
  // Of a diverged run. The row of the particle that is not finite or, when all are, the fastest; -1: not known.
  int fault_row = -1;
  double fault_speed = 0;  // m/s of that particle, infinite when it is not finite
  // The row whose material at rest allows the smallest step, and that step in s (timestep.h, rest_limit).
  int stiffest_row = -1;
  double stiffest_limit = 0;
  std::vector<StiffRow> stiff_rows;  // unless Options::stiff is off
  std::vector<RigidBodyReport> rigid_bodies;
  ImpactHistory impacts;
  int frames_done = 0;            // output frames handed out
  long long steps = 0;            // substeps done
  double dt = 0;                  // s; the mean of the substeps under StepRule::cfl
  double max_speed = 0;           // m/s, over all substeps
  StepHistory history;            // the range of steps, and retries; no retries under StepRule::fixed
  double min_J = 1, max_J = 1;    // over output frames
  std::vector<Balance> balances;  // one per frame handed out
  bool measured_energy = false, measured_steps = false;  // what the balances hold
  long long particles_outside = 0;  // most particles that had to be held at the edge of the grid in one substep
  long long particles_at_wall = 0;  // most of at_wall over output frames
  std::vector<Omission> omitted;    // what this problem did not need
  // Run time; never part of a result's identity.
  int threads = 0;  // used
  int sorts = 0;
  double seconds_particles = 0, seconds_grid = 0, seconds_sort = 0, seconds_frames = 0, seconds_total = 0;
  double particle_steps_per_second = 0;
  size_t particle_bytes = 0, grid_bytes = 0;  // most memory of the solver for particles and for active grid nodes
};

// Throws invalid_input for broken input; `run` begins with it.
void check_problem(const Problem& problem, const Timing& timing);

// Integrates the problem. A diverged run is a result; broken input (a row out of range, a position that is not finite,
// a volume that is not positive, a parameter outside its domain) throws invalid_input (exit code 3).
Result run(const Problem& problem, const Timing& timing, const Options& options, const FrameCallback& callback);

EnergyResidual energy_residual(const Result& result);

}  // namespace physmas::mpm

#endif
