// Output frames and substeps from the run, the candidate and the rule.
#include "bind/timing.h"

#include <doctest/doctest.h>

#include "unit/bind/scenes.h"
#include "unit/input_error.h"

using namespace physmas;

namespace {

RunSpecification::Time run_time() {
  RunSpecification::Time time;
  time.frames = 7;
  time.frame_dt = 0.04;
  time.substep_dt = 3e-4;  // 133 1/3 of them fill a frame
  return time;
}

bind::BoundTiming timing(const std::string& rule) {
  return bind::bind_timing(rule, run_time(), bind_test::candidate(), "c.json");
}

}  // namespace

TEST_CASE("bind: the paper's rule takes the candidate's substeps, cfl the base step, a number itself") {
  const bind::BoundTiming paper = timing("paper");
  CHECK(paper.rule == "paper");
  CHECK(paper.timing.frames == 7);
  CHECK(paper.timing.frame_dt == 0.04);
  CHECK(paper.timing.substeps == 200);
  CHECK(paper.timing.rule == mpm::StepRule::fixed);

  const bind::BoundTiming cfl = timing("cfl");
  CHECK(cfl.rule == "cfl");
  CHECK(cfl.timing.rule == mpm::StepRule::cfl);
  CHECK(cfl.timing.substeps == 134);

  const bind::BoundTiming fixed = timing("1e-3");
  CHECK(fixed.rule == "fixed");
  CHECK(fixed.timing.rule == mpm::StepRule::fixed);
  CHECK(fixed.timing.substeps == 40);           // divides the frame: the relative slack keeps rounding out
  CHECK(timing("0.011").timing.substeps == 4);  // never longer than asked for
  CHECK(timing("5").timing.substeps == 1);      // longer than a frame
}

TEST_CASE("bind: a rule that is none, and substeps that do not fill a frame, are refused") {
  for (const std::string rule : {"", "papers", "1e-3s", "0", "-1", "nan", "1e-30"}) {
    CHECK(message_of([&] { timing(rule); }, ExitCode::usage) ==
          "--timestep: found \"" + rule + "\", expected paper, cfl or a positive number of seconds");
  }
  Candidate candidate = bind_test::candidate();
  candidate.timestep.dt = 2.1e-4;
  CHECK(message_of([&] { bind::bind_timing("paper", run_time(), candidate, "c.json"); }) ==
        "c.json: /timestep/dt: found 0.00021, expected 200 substeps that fill a frame of 0.04 s; make the candidates "
        "again with pm-candidates");
  CHECK(bind::bind_timing("cfl", run_time(), candidate, "c.json").timing.substeps ==
        134);  // the candidate's is ignored
}
