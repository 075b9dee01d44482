// Candidates and what they must fit.
#include "records/candidate.h"

#include <doctest/doctest.h>

#include "records/inventory.h"
#include "records/state.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

Inventory inventory() {
  Inventory inventory;
  for (const auto& [object, part] : {std::pair("a", "x"), std::pair("a", "y"), std::pair("b", "x")}) {
    InventoryRow row;
    row.object = object;
    row.part = part;
    inventory.rows.push_back(row);
  }
  inventory.rows[1].residual = true;
  return inventory;
}

Candidate candidate() {
  Candidate candidate;
  candidate.id = "stiff";
  candidate.transform = "stiff";
  for (const auto& [key, row] : {std::pair("b/x", 2), std::pair("a/x", 0)}) {
    CandidateRow r;
    r.key = key;
    r.row = row;
    r.E = 1e6;
    r.nu = 0.3;
    r.rho = 1000;
    candidate.rows.push_back(r);
  }
  candidate.timestep.c_max = candidate.timestep.c_ref = 40;
  candidate.timestep.target = 2e-4;
  candidate.timestep.dt = 2e-4;
  candidate.timestep.substeps = 200;
  return candidate;
}

}  // namespace

TEST_CASE("records: a candidate must have the id it is asked for and rows of the inventory") {
  TemporaryFolder folder;
  Provenance provenance;
  provenance.tool = "test";
  const std::string path = folder / "c.json";
  const auto refusal = [&](const Candidate& c, const std::string& id) {
    save_candidate(path, c, provenance);
    return message_of([&] { load_candidate(path, id, inventory()); });
  };
  CHECK(refusal(candidate(), "stiff") == "no error");
  CHECK(load_candidate(path, "stiff", inventory()).rows[1].key == "a/x");
  CHECK(refusal(candidate(), "soft") == path + ": /id: found \"stiff\", expected \"soft\"");
  Candidate wrong = candidate();
  wrong.rows[1].row = 1;  // that of a/y
  CHECK(refusal(wrong, "stiff") == path + ": /rows/1/key: found \"a/x\", expected the inventory's key of this row");
  wrong.rows[1].row = 3;  // past the end
  CHECK(refusal(wrong, "stiff").find("/rows/1/key") != std::string::npos);
}

TEST_CASE("records: keys and residual rows of an inventory, sums over the rows of a state") {
  CHECK(inventory().row_keys() == std::vector<std::string>{"a/x", "a/y", "b/x"});
  CHECK(inventory().residual_rows() == std::vector<bool>{false, true, false});
  State state;
  state.row_keys = inventory().row_keys();
  state.gaussian_row = {2, 0, 2};
  state.row = {2, 0, 2, 0};
  state.volume = {1, 2, 4, 8};
  CHECK(state.gaussians_per_row() == std::vector<long>{1, 0, 2});
  CHECK(state.volume_per_row() == std::vector<double>{10, 0, 5});
}
