// A hand-authored MPM configuration: what stands in for evidence and plan. Written by the user; the registered
// references of the benchmark are such files.
#ifndef PHYSMAS_RECORDS_CONFIGURATION_H
#define PHYSMAS_RECORDS_CONFIGURATION_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/labels.h"
#include "records/plan.h"

namespace physmas {

struct AuthoredRow {
  int row = 0;  // index in inventory.rows
  Branch branch = Branch::jelly;
  double E = 0, nu = 0, rho = 0;  // Pa, -, kg/m^3, solver space
};

struct AuthoredConfiguration {
  std::vector<AuthoredRow> rows;  // one per semantic row, inventory order
  std::vector<PlanAction> actions;
  std::vector<std::string> settings;  // KEY=VALUE, run settings to simulate with
};

// Errors (exit code 3): a semantic row of the inventory that the file lacks, a key that is none of them, an action that
// does not resolve.
AuthoredConfiguration load_configuration(const std::string& path, const Inventory& inventory);

}  // namespace physmas

#endif
