// What a stepper is made for, and what it says of itself.
#include "mpm/stepper.h"

#include <doctest/doctest.h>

#include "base/device.h"
#include "base/error.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

TEST_CASE("mpm stepper: a device that is not there is a usage error, of the solver and of a run") {
  if (cuda_absence().empty()) return;  // it is there
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  add_block(p, {0.8, 0.8, 0.8}, {0.9, 0.9, 0.9}, 0, p.domain.dx());
  Options o = options();
  o.device.kind = Device::Kind::cuda;
  ExitCode code = ExitCode::done;
  try {
    simulate(p, {2, 0.01, 10}, o);
  } catch (const Error& e) {
    code = e.code();
  }
  CHECK(code == ExitCode::usage);
}

TEST_CASE("mpm stepper: it uses no more threads than asked for, and fewer where particles are few") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  add_block(p, {0.5, 0.5, 0.5}, {1.0, 1.0, 1.0}, 0, p.domain.dx());
  StepperSetup setup;
  setup.domain = p.domain;
  setup.branches = {Branch::jelly};
  setup.parameters = {derive_parameters(p.materials[0], {})};
  setup.row = p.particles.row;
  setup.volume = p.particles.volume;
  setup.control_group.assign(setup.row.size(), 0);
  REQUIRE(setup.row.size() > 4000);
  const auto threads = [&](int wanted) {
    return make_stepper({Device::Kind::cpu, wanted}, Precision::single, setup)->usage().threads;
  };
  CHECK(threads(1) == 1);
  CHECK(threads(2) == 2);
  CHECK(threads(1000) == static_cast<int>(setup.row.size() / 2000));
}

TEST_CASE("mpm stepper: the share of the grid in use is that of the blocks that particles reach") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000}, 31);
  p.particles.position = {{1, 1, 1}};
  p.particles.volume = {1e-5};
  p.particles.row = {0};
  const Outcome out = simulate(p, {2, 0.01, 10});
  // One particle reaches 1 to 8 of 8^3 blocks: 99 or 98 %, rounded down.
  const std::string text = out.result.omitted.back().why;
  CHECK((text.substr(0, 2) == "99" || text.substr(0, 2) == "98"));
}
