// What to try when a gate fails.
#include "screen/advice.h"

#include <doctest/doctest.h>

#include "screen/explain.h"
#include "splat/best_video.h"

using namespace physmas;
using namespace physmas::screen;

namespace {

ScreenedCandidate candidate() {
  ScreenedCandidate c;
  c.id = c.transform = "soft";
  c.rank = 1;
  c.score = 0.6512;
  c.gates = {{"plan", true, {{"resolved", true}}, {{"resolved", true}}},
             {"spread", false, {{"area_growth", 3.5}}, {{"area_growth_at_most", 2.0}}, "Ask for less."}};
  return c;
}

}  // namespace

TEST_CASE("screen: every gate has a sentence of advice; a diverged simulation has its own") {
  ExecutionRecord execution;
  for (const char* gate : {"plan", "process", "numerical", "spread", "flattening", "support", "achieved", "stillness", "score"}) {
    const std::string text = advice_for(gate, execution);
    CHECK(text.size() > 40);
    CHECK(text.back() == '.');
    CHECK(text.find('\n') == std::string::npos);
    CHECK(advice_table().find(gate + ("\t" + text + "\n")) != std::string::npos);
  }
  CHECK_THROWS_AS(advice_for("taste", execution), Error);
  execution.divergence = Divergence();
  execution.divergence->advice = "the motion breaks down; try this";
  CHECK(advice_for("numerical", execution) == "The motion breaks down; try this.");
  CHECK(advice_for("spread", execution) == advice_for("spread", {}));
}

TEST_CASE("screen: the table for people has the advice below what failed") {
  ScreenRecord record;
  record.candidates = {candidate()};
  record.candidates[0].advice = "Lower tau.";
  const std::string text = explain(record);
  CHECK(text.find("spread      FAILED  area growth 3.5; limit: area growth at most 2\n              Ask for less.\n") !=
        std::string::npos);
  CHECK(text.find("score       FAILED  0.6512; limit: 0.72\n              Lower tau.\n") != std::string::npos);
  CHECK(text.find("plan        pass") != std::string::npos);
}

TEST_CASE("splat: the best video says why it was not accepted") {
  ScreenRecord record;
  ScreenedCandidate c = candidate();
  CHECK(splat::reasons_of(c, record) == std::vector<std::string>{"Not accepted: soft", "spread: Ask for less."});
  c.gates[1].passed = true;
  c.gates[1].advice.clear();
  c.advice = "Lower tau.";
  CHECK(splat::reasons_of(c, record) ==
        std::vector<std::string>{"Not accepted: soft", "score: Q 0.65, needed 0.72. Lower tau."});
  c.advice.clear();
  record.audited = true;
  record.reason = "soft failed its audit: video exists: found false, expected true";
  CHECK(splat::reasons_of(c, record).back() == record.reason);
}
