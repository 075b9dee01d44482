// A small state and candidate that belong together.
#ifndef PHYSMAS_TESTS_BIND_SCENES_H
#define PHYSMAS_TESTS_BIND_SCENES_H

#include "records/candidate.h"
#include "records/state.h"

namespace bind_test {

// Rows a/x, a/y, b/x and b/unused; two Gaussians and a filled particle; nothing belongs to the last row.
inline physmas::State state() {
  physmas::State state;
  state.row_keys = {"a/x", "a/y", "b/x", "b/unused"};
  state.gaussian_object = {0, 1};
  state.gaussian_row = {1, 2};
  state.position = {{0.5f, 0.25f, 0.125f}, {1, 1.25f, 1.5f}, {0.75f, 0.5f, 1.75f}};
  state.volume = {1e-6f, 2e-6f, 3e-6f};
  state.row = {1, 2, 0};
  return state;
}

inline physmas::CandidateRow row(const char* key, int index, physmas::Branch branch, double E, double nu, double rho) {
  physmas::CandidateRow row;
  row.key = key;
  row.row = index;
  row.branch = branch;
  row.E = E;
  row.nu = nu;
  row.rho = rho;
  return row;
}

// The rows that have particles, not in the inventory's order.
inline physmas::Candidate candidate() {
  physmas::Candidate candidate;
  candidate.id = "posterior";
  candidate.rows = {row("b/x", 2, physmas::Branch::sand, 3e5, 0.3, 1300),
                    row("a/x", 0, physmas::Branch::metal, 1e7, 0.1, 1100),
                    row("a/y", 1, physmas::Branch::foam, 2e4, 0.2, 1200)};
  candidate.timestep.substeps = 200;
  candidate.timestep.dt = 2e-4;
  return candidate;
}

}  // namespace bind_test

#endif
