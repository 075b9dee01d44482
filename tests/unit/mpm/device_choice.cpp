// What --device auto takes, and the reason that it gives.
#include "mpm/device_choice.h"

#include <doctest/doctest.h>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

TEST_CASE("mpm device: auto takes a GPU for long work where there is one, and says why") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  p.particles.position.resize(200000);
  Options o = options(Precision::single, 1);
  o.device.automatic = true;
  const auto there = [] { return std::string(); };
  const auto not_there = [] { return std::string("no card is plugged in"); };
  const Timing paper = {50, 0.04, 200};
  const DeviceChoice taken = mpm::choose_device(p, paper, o, there);
  CHECK(taken.device.kind == Device::Kind::cuda);
  CHECK(!taken.device.automatic);
  CHECK(taken.device.threads == 1);
  CHECK(taken.why.find("s of work for the CPU") != std::string::npos);

  const DeviceChoice lacking = mpm::choose_device(p, paper, o, not_there);
  CHECK(lacking.device.kind == Device::Kind::cpu);
  CHECK(lacking.why == "no card is plugged in");

  // A driver that is not asked cannot fail, nor cost time.
  p.particles.position.resize(2000);
  const DeviceChoice small = mpm::choose_device(p, paper, o, []() -> std::string { throw 1; });
  CHECK(small.device.kind == Device::Kind::cpu);
  CHECK(small.why.find("less than a GPU is worth") != std::string::npos);
}

TEST_CASE("mpm device: what was asked for is taken, and what a GPU does not do is left to the CPU") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  p.particles.position.resize(200000);
  Options o = options(Precision::single, 1);
  const Timing paper = {50, 0.04, 200};
  const auto there = [] { return std::string(); };
  CHECK(mpm::choose_device(p, paper, o, there).device.kind == Device::Kind::cpu);
  CHECK(mpm::choose_device(p, paper, o, there).why == "asked for");
  o.device.kind = Device::Kind::cuda;
  CHECK(mpm::choose_device(p, paper, o, there).device.kind == Device::Kind::cuda);
  o.device = {Device::Kind::cpu, 1, true};
  o.measure_steps = true;
  const DeviceChoice measured = mpm::choose_device(p, paper, o, there);
  CHECK(measured.device.kind == Device::Kind::cpu);
  CHECK(measured.why.find("measured on the CPU only") != std::string::npos);
}

TEST_CASE("mpm device: a GPU that fails is no end where auto took it, and is where it was asked for") {
  const auto work = [](const Device& device) {
    if (device.kind == Device::Kind::cuda) throw Error(ExitCode::invalid_input, "the card has 3 MB free");
    return 7;
  };
  int told = 0;
  const auto tell = [&](const char*) { ++told; };
  DeviceChoice choice = {{Device::Kind::cuda, 1}, "long work"};
  CHECK(on_chosen_device(choice, true, work, tell) == 7);
  CHECK(told == 1);
  CHECK(choice.device.kind == Device::Kind::cpu);
  CHECK(choice.why == "the GPU failed: the card has 3 MB free");
  choice = {{Device::Kind::cuda, 1}, "asked for"};
  CHECK_THROWS_AS(on_chosen_device(choice, false, work, tell), Error);
  // What is wrong with the input is so on the CPU, too.
  choice = {{Device::Kind::cuda, 1}, "long work"};
  const auto broken = [](const Device&) -> int { throw Error(ExitCode::invalid_input, "broken"); };
  CHECK_THROWS_AS(on_chosen_device(choice, true, broken, tell), Error);
}
