// What came apart is said; what only moved, turned or stretched is not.
#include "bind/tearing.h"

#include <doctest/doctest.h>

#include "unit/bind/scenes.h"

using namespace physmas;
using mpm::Vec3d;

namespace {

// Two rows of one object on top of each other, and a row of another one beside them; 0.5 cells between particles.
struct Bench {
  Candidate candidate;
  mpm::Problem problem;
  std::vector<Vec3d> x;

  Bench() {
    problem.domain.n = 40;
    candidate.rows = {bind_test::row("cake/top", 0, Branch::jelly, 1e5, 0.3, 1000),
                      bind_test::row("cake/base", 1, Branch::foam, 1e5, 0.3, 1000),
                      bind_test::row("sand/heap", 2, Branch::sand, 1e5, 0.3, 1000)};
    const double h = 0.5 * problem.domain.dx();
    for (int row = 0; row < 3; ++row) {
      for (int i = 0; i < 6 * 6 * 4; ++i) {
        const double shift = row == 2 ? 12 * h : 0, lift = row == 0 ? 4 * h : 0;
        problem.particles.position.push_back({0.5 + shift + i % 6 * h, 0.5 + i / 6 % 6 * h, 0.5 + lift + i / 36 * h});
        problem.particles.row.push_back(row);
      }
    }
    x = problem.particles.position;
  }
  std::vector<TornRow> torn() const { return bind::torn_rows(candidate, problem, x); }
  template <class Function>
  void move(int row, const Function& function) {
    for (size_t i = 0; i < x.size(); ++i) {
      if (problem.particles.row[i] == row) function(x[i]);
    }
  }
};

}  // namespace

TEST_CASE("bind: what moves, turns or stretches has not come apart") {
  Bench bench;
  CHECK(bench.torn().empty());
  for (int row = 0; row < 2; ++row) bench.move(row, [](Vec3d& x) { x = {2 * x.y, -x.x, x.z + 0.3}; });
  CHECK(bench.torn().empty());
  // Objects part without a word, and so does sand.
  bench.move(2, [](Vec3d& x) { x = 10.0 * x; });
  CHECK(bench.torn().empty());
}

TEST_CASE("bind: a row that is lifted off its object, torn in two or lost is named with its share") {
  Bench bench;
  SUBCASE("lifted off") {
    bench.move(0, [](Vec3d& x) { x.z += 0.4; });
    const std::vector<TornRow> torn = bench.torn();
    REQUIRE(torn.size() == 1);
    CHECK(torn[0].key == "cake/top");
    CHECK(torn[0].from == "cake/base");
    CHECK(torn[0].share == 1);
    CHECK(bind::torn_line(torn[0]).find("cake/top comes off cake/base (100 % of what joined them") == 0);
  }
  SUBCASE("scattered") {
    bench.move(1, [](Vec3d& x) { x = 8.0 * x; });
    const std::vector<TornRow> torn = bench.torn();
    REQUIRE(torn.size() == 2);  // and off its neighbour
    CHECK(torn[1].key == "cake/base");
    CHECK(torn[1].from.empty());
    CHECK(torn[1].share == 1);
    CHECK(bind::torn_line(torn[1]).find("cake/base comes apart (100 %") == 0);
  }
  SUBCASE("not finite") {
    bench.x[0].x = std::nan("");
    bench.move(0, [](Vec3d& x) { x.x += std::nan(""); });
    REQUIRE(!bench.torn().empty());
    CHECK(bench.torn()[0].key == "cake/top");
    CHECK(bench.torn()[0].share == 1);
  }
}
