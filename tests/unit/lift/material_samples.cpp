// Particles and the samples of a material field near them.
#include "lift/material_samples.h"

#include <doctest/doctest.h>

#include "unit/input_error.h"

using namespace physmas;

namespace {

// A scene of scale 0.5 that is moved by 1; cells are 0.02.
State state() {
  State state;
  state.map.s = 0.5;
  state.map.d = {1, 1, 1};
  state.position = {{1, 1, 1}, {1.25f, 1, 1}, {1.5f, 1, 1}};
  state.row = {0, 0, 0};
  return state;
}

MaterialField field(std::vector<Eigen::Vector3f> positions) {
  MaterialField field;
  field.position = std::move(positions);
  for (size_t i = 0; i < field.position.size(); ++i) {
    field.E.push_back(1e6f * static_cast<float>(i + 1));
    field.nu.push_back(0.1f * static_cast<float>(i + 1));
    field.rho.push_back(1000.f * static_cast<float>(i + 1));
  }
  return field;
}

}  // namespace

TEST_CASE("material samples: each particle takes the nearest one, in scene space") {
  // In solver space at 1.24, 1.265 and 1.48: 0.025 apart, so that the reach is 0.05.
  const ParticleField got =
      lift::sample_particles(field({{0.48f, 0, 0}, {0.53f, 0, 0}, {0.96f, 0, 0}}), state(), {}, "f.h5");
  CHECK(got.E == std::vector<float>{0, 1e6f, 3e6f});
  CHECK(got.nu == std::vector<float>{0, 0.1f, 0.3f});
  CHECK(got.rho == std::vector<float>{0, 1000, 3000});
  CHECK_FALSE(got.has_sample(0));
  CHECK(got.has_sample(1));
}

TEST_CASE("material samples: ties go to the sample that comes first") {
  CHECK(lift::sample_particles(field({{0.5f, 0.02f, 0}, {0.5f, 0, 0.02f}}), state(), {}, "f.h5").E[1] == 1e6f);
}

TEST_CASE("material samples: the reach is two cells, twice the samples' spacing, or what the run says") {
  RunSpecification run;
  CHECK(lift::sample_particles(field({{0, 0, 0}}), state(), run, "f").reach == doctest::Approx(0.04));
  // 0.5 apart in the scene, 0.25 in the solver.
  const ParticleField wide = lift::sample_particles(field({{-0.5f, 0, 0}, {0, 0, 0}}), state(), run, "f");
  CHECK(wide.reach == doctest::Approx(0.5));
  CHECK(wide.E == std::vector<float>{2e6f, 2e6f, 2e6f});
  run.lifting.field_reach = 3;
  const ParticleField near = lift::sample_particles(field({{-0.5f, 0, 0}, {0, 0, 0}}), state(), run, "f");
  CHECK(near.reach == doctest::Approx(0.06));
  CHECK(near.E == std::vector<float>{2e6f, 0, 0});
}

TEST_CASE("material samples: a field that no particle is near is refused") {
  CHECK(
      message_of([&] {
        lift::sample_particles(field({{50, 0, 0}}), state(), {}, "f.h5");
      }) ==
      "f.h5: /samples/position: found no sample within 0.08 (scene units) of any particle, expected samples where the "
      "Gaussians are, in their coordinates");
}
