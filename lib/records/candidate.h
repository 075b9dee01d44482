// candidates/ID.json and candidates/roundN.json: executable configurations and their fixed order.
#ifndef PHYSMAS_RECORDS_CANDIDATE_H
#define PHYSMAS_RECORDS_CANDIDATE_H

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "records/labels.h"
#include "records/provenance.h"
#include "records/schedule_operation.h"

namespace physmas {

struct Inventory;

// E [Pa], Poisson's ratio and density [kg/m^3] of a particle, in solver space.
struct ParticleNumbers {
  double E, nu, rho;
};

// One row Theta_r: branch, E [Pa], nu, rho [kg/m^3], all in solver space.
struct CandidateRow {
  std::string key;
  int row = 0;  // index in inventory.rows
  Branch branch = Branch::jelly;
  double E = 0, nu = 0, rho = 0;
  int label = 0;  // index into kLabels
  bool residual = false;
  // Where a material field says what the row's particles are made of: what E, nu and rho stand for among its numbers,
  // and the label in whose domain these are taken (records/particle_material.h).
  struct Field {
    ParticleNumbers numbers;
    int label;
  };
  std::optional<Field> field;
};

// Result of the heterogeneous step-size rule (paper, Eq. supp-adaptivedt).
struct TimestepResult {
  double c_max = 0, c_ref = 0;  // m/s
  double target = 0;            // s
  int substeps = 1;             // per output frame
  double dt = 0;                // s
  std::string capped_by = "none";
};

struct Candidate {
  std::string id;
  std::string transform;
  std::string parent;  // empty: an initial candidate
  int order = 0;
  int round = 0;
  double base_confidence = 0;
  std::vector<CandidateRow> rows;
  std::vector<std::pair<std::string, double>> projection;  // support row key -> eta, row order
  std::vector<std::string> retention;                      // support row keys
  std::vector<ScheduleOperation> schedule;
  TimestepResult timestep;
  std::vector<Omission> omitted;
};

Candidate load_candidate(const std::string& path);
// The candidate with this id, whose rows are rows of the inventory; another one is an Error (exit code 3).
Candidate load_candidate(const std::string& path, const std::string& id, const Inventory& inventory);
void save_candidate(const std::string& path, const Candidate& candidate, const Provenance& provenance);

// The ordered ids of one round.
struct CandidateRound {
  int round = 0;
  std::vector<std::string> ids;
  std::vector<Omission> omitted;
};
CandidateRound load_round(const std::string& path);
void save_round(const std::string& path, const CandidateRound& round, const Provenance& provenance);

}  // namespace physmas

#endif
