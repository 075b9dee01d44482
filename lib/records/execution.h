// rollouts/ID.json: the execution record D^(c) of a simulated candidate.
#ifndef PHYSMAS_RECORDS_EXECUTION_H
#define PHYSMAS_RECORDS_EXECUTION_H

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "records/actions.h"
#include "records/json.h"

namespace physmas {

// Why a simulation diverged, for a person.
struct Divergence {
  std::string cause;  // step: the substep is too long for `row`; motion: `row` moves faster than the solver follows;
                      // budget: more substeps are needed than are allowed
  std::string row;    // key
  double E = 0;       // Pa
  double wave_speed = 0;  // m/s: dx over the largest stable step of its material at rest
  double dx = 0;          // m, edge of a cell
  double dt = 0;          // s, the substep that was used
  double needed_dt = 0;   // s: that the time.rule cfl takes for its material at rest
  int frame = 0;          // the output frame that was not reached
  std::string advice;     // one sentence: what happened, and what to set
};

// A simulation before the one whose rollout stands, or after it and in vain (time.on_divergence).
struct Attempt {
  std::string rule;  // of the substeps: paper | cfl | fixed
  bool diverged = false;
  std::string reason;  // as in the record
  int frames = 0;
  long steps = 0, allowed = 0;  // substeps done, and allowed
};

// What was found for time.start: equilibrium (mpm/equilibrium.h).
struct StartRecord {
  int supported_parts = 0, free_parts = 0;
  long supported_particles = 0;
  int iterations = 0, corrections = 0;
  double residual = 0;        // of gravity, felt by the supported particles in the first substep
  double largest_strain = 0;  // logarithm of a principal stretch
  std::vector<std::pair<std::string, long>> limited;  // rows and their particles that bear less than was asked
};

// What an action of the schedule asked for and what it reached (docs/actions.md, "What was achieved").
struct AchievedAction {
  ActionType type = ActionType::translation;
  std::vector<std::string> rows;  // keys of what it was measured on
  std::string quantity;           // angle | displacement | ratio | speed | spread | drift
  std::string unit;               // rad, m, m/s; empty: a ratio
  double requested = 0, achieved = 0;
  double share = 0;       // of the request that was met, 0..1
  std::string shortfall;  // where much is missing: why, and what to change; else empty
};

// Rows that nothing moved or touched, and that stood on something: how far they drifted all the same.
struct Stillness {
  std::vector<std::string> rows;  // keys
  double drift = 0;               // m: mean over a row's particles, of the row that drifted most
  double share = 0;               // 1: none; 0: a tenth of the scene's longest side or more
};

// A row whose particles have lost neighbours that they had at rest: of their own row, or of another one.
struct TornRow {
  std::string key, from;  // from: the other row's, empty: within the row
  double share = 0;       // of these bonds that are broken, 0..1
};

// A row whose material allows no step as long as the run's (time.stiff).
struct StiffRowRecord {
  std::string key;
  bool rigid = false;       // it keeps its shape; else it deforms
  std::string why;          // one clause
  double limit = 0;         // s: its largest stable step
  double deflection = 0;    // estimated, under its own weight, over its length; 0: not estimated
  std::vector<int> bodies;  // of RigidRecord::bodies
};

// A body that keeps its shape, of one or several rows or of a part of one.
struct RigidBodyRecord {
  std::vector<std::string> rows;
  double mass = 0;                  // kg
  long impacts = 0;                 // that were met without a window
  double restitution = -1;          // measured in windows; -1: none
  double largest_acceleration = 0;  // m/s^2, between impacts
  double largest_jump = 0;          // m/s: of its velocity in one substep
  double error = 0;                 // bound of what it would have bent by between impacts, over its length
};

// Short times in which bodies deform, because they hit something.
struct ImpactWindowsRecord {
  long count = 0, substeps = 0, small_steps = 0;
};

struct ExecutionRecord {
  std::string candidate;
  int exit = 0, signal = 0;  // how the process ended
  bool diverged = false;
  std::vector<std::string> error_tokens;  // numerical and run-time errors, empty when there were none
  std::string reason;                     // one sentence on the divergence
  std::optional<Divergence> divergence;   // of a diverged one
  std::vector<Attempt> attempts;          // all, in order, where there was more than one
  long first_bad_step = -1;               // -1: none
  double max_speed = 0;                   // m/s, solver space
  double J_min = 1, J_max = 1;
  double mass = 0;                                                                                   // kg
  Eigen::Vector3d momentum_start = Eigen::Vector3d::Zero(), momentum_end = Eigen::Vector3d::Zero();  // kg m/s
  std::vector<double> kinetic, elastic, potential;  // J of solver space, per output frame; elastic empty: not measured
  std::string energy_measured = "frames";           // "off", "frames", "steps"
  double energy_residual = 0, energy_scale = 0;     // J; what they mean depends on energy_measured, see the schema
  double largest_step_residual = 0;                 // J, with "steps"
  // With "steps": the terms of the budget, sums since the start, per output frame [J].
  std::vector<std::pair<std::string, std::vector<double>>> energy_terms;
  long particles_outside = 0;
  std::string step_rule = "paper";  // paper | cfl | fixed
  int substeps_per_frame = 1;       // cfl: at least
  long steps = 0;
  double dt = 0;                           // s; cfl: the mean
  double smallest_dt = 0, largest_dt = 0;  // s
  long retries = 0, discarded_steps = 0;   // cfl: chunks done again with a smaller step, and substeps thrown away
  int frames = 0;
  std::vector<AchievedAction> achieved;  // one per action of the schedule, in its order
  std::optional<Stillness> stillness;    // none: no row was to stand still
  std::vector<TornRow> torn;             // at the last frame
  long particles = 0;
  Json grid = Json::object();
  std::string precision = "float";
  std::string deformation = "elastic";     // what the rollout's F is: elastic or total
  std::vector<StiffRowRecord> stiff_rows;  // with time.stiff
  std::vector<RigidBodyRecord> rigid_bodies;
  ImpactWindowsRecord impacts;
  std::optional<StartRecord> start;  // none: from rest, F = I
  std::vector<Omission> omitted;
  Json runtime = Json::object();  // seconds by phase, particle-steps per second, peak memory
};

ExecutionRecord load_execution(const std::string& path);
// The record beside a rollout, "rollouts/ID.h5". A rollout that is not the one which was written with it is an Error
// (exit code 3).
ExecutionRecord load_execution_of(const std::string& rollout);
// Where that record is.
std::string execution_path_of(const std::string& rollout);
void save_execution(const std::string& path, const ExecutionRecord& record, const Provenance& provenance);

}  // namespace physmas

#endif
