// Threads that share loops.
#include "base/team.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <vector>

TEST_CASE("team: every call is made once, and calls may wait for calls of other ranges that precede them") {
  for (const int threads : {1, 2, 3}) {
    physmas::Team team(threads);
    for (int job = 0; job < 2000; ++job) {
      const int count = 2 + job % 40;
      std::vector<int> bounds = {0};
      for (int t = 1; t < threads; ++t) bounds.push_back(std::max(bounds.back(), (job * t) % (count + 1)));
      bounds.push_back(count);
      // Stages, ascending in every range: a call waits for all calls of earlier stages.
      std::vector<int> stage(count);
      for (int t = 0; t < threads; ++t) {
        const int size = bounds[t + 1] - bounds[t];
        for (int i = 0; i < size; ++i) stage[bounds[t] + i] = 8 * i / size;
      }
      std::vector<std::atomic<int>> calls(count);
      const auto wait_and_count = [&](int i) {
        for (int other = 0; threads > 1 && other < count; ++other) {
          for (int round = 0; stage[other] < stage[i] && calls[other] == 0; ++round) physmas::Team::pause(round);
        }
        ++calls[i];
      };
      // Where the first range has everything the calling thread goes through it in order.
      team.for_each(bounds, wait_and_count);
      int wrong = 0;
      for (const auto& c : calls) wrong += c != 1;
      REQUIRE(wrong == 0);
    }
  }
}
