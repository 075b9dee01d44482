// Rollout frames in scene space.
#include "splat/rollout_frames.h"

#include <doctest/doctest.h>

#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

TEST_CASE("splat: a rollout's frames in scene space, in any order") {
  TemporaryFolder folder;
  Provenance provenance;
  provenance.tool = "test";
  RolloutWriter writer(folder / "r.h5", 2, "elastic", provenance);
  const std::vector<float> velocity(6, 9.0f);
  for (int t = 0; t < 3; ++t) {
    std::vector<float> position, F;
    for (int k = 0; k < 6; ++k) position.push_back(static_cast<float>(1 + t + k));
    for (int k = 0; k < 18; ++k) F.push_back(static_cast<float>(100 * t + k));
    writer.append(0.25 * t, position.data(), F.data(), velocity.data());
  }
  writer.commit();
  State state;
  state.gaussian_row = {0, 0};
  state.map.s = 2;
  state.map.d = {1, 2, 3};

  const splat::RolloutFrames frames(folder / "r.h5", state);
  REQUIRE(frames.count() == 3);
  for (const int t : {2, 0, 1}) {
    CHECK(frames.time(t) == 0.25 * t);
    const splat::TransportedFrame frame = frames.frame(t);
    // (x - d) / s of (1, 2, 3) + t and (4, 5, 6) + t.
    CHECK(frame.position(0) == Eigen::Vector3f::Constant(0.5f * t));
    CHECK(frame.position(1) == Eigen::Vector3f::Constant(0.5f * (t + 3)));
    for (int i = 0; i < 2; ++i) {
      for (int k = 0; k < 9; ++k) CHECK(frame.F(i)(k / 3, k % 3) == 100 * t + 9 * i + k);
    }
    CHECK(frame.deformation().position[1] == frame.position(1));
    CHECK(frame.deformation().F[1] == frame.F(1));
  }
  state.gaussian_row.push_back(0);
  CHECK(message_of([&] { splat::RolloutFrames(folder / "r.h5", state); }).find("shape [3, 3, 3]") != std::string::npos);
}
