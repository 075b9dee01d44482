// Labels without islands.
#include "lift/islands.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>

using namespace physmas;
using namespace physmas::lift;

namespace {

constexpr double kCell = 0.1;

// Two objects: a with parts one, two and its residual row; b with one part.
Inventory inventory() {
  Inventory inventory;
  inventory.objects.resize(2);
  inventory.objects[0].id = "a", inventory.objects[1].id = "b";
  for (const auto& [object, part] : {std::pair("a", "one"), {"a", "two"}, {"a", "residual"}, {"b", "body"}}) {
    InventoryRow row;
    row.object = object;
    row.part = part;
    row.residual = std::string(part) == "residual";
    inventory.rows.push_back(row);
  }
  return inventory;
}

// Blocks of Gaussians 0.05 apart.
struct Scene {
  Gaussians gaussians;
  Labels labels;
  void block(const Eigen::Vector3f& corner, int x, int y, int z, int row) {
    for (int i = 0; i < x * y * z; ++i) {
      gaussians.position.push_back(corner + 0.05f * Eigen::Vector3f(i % x, i / x % y, i / (x * y)));
      labels.row.push_back(row);
      labels.object.push_back(row == 3 ? 1 : 0);
      labels.confidence.push_back(0.9f);
    }
  }
  Islands join() { return join_islands(gaussians, inventory(), kCell, labels); }
  int last() const { return labels.row.back(); }
};

// Part one, a block of 1,000; part two stands 0.05 beside it.
Scene two_blocks() {
  Scene scene;
  scene.block({0, 0, 0}, 10, 10, 10, 0);
  scene.block({0.5f, 0, 0}, 10, 10, 10, 1);
  return scene;
}

}  // namespace

TEST_CASE("lift: labels without islands stay as they are") {
  Scene scene = two_blocks();
  const Labels before = scene.labels;
  const Islands islands = scene.join();
  CHECK(islands.omitted.empty());
  CHECK(scene.labels.row == before.row);
  CHECK(scene.labels.confidence == before.confidence);
}

TEST_CASE("lift: a chip of one part in another goes to that, with little confidence") {
  Scene scene = two_blocks();
  scene.block({0.82f, 0.22f, 0.22f}, 2, 2, 2, 0);  // of part one, inside part two
  const Islands islands = scene.join();
  CHECK(scene.last() == 1);
  CHECK(scene.labels.confidence.back() == doctest::Approx(0.2));
  CHECK(islands.given == 8);
  CHECK(islands.given_pieces == 1);
  CHECK(islands.apart == 0);
  REQUIRE(islands.omitted.size() == 1);
  CHECK(islands.omitted[0].what == "islands of a/one");
  CHECK(islands.omitted[0].why == "Gaussians in small pieces apart from it: 8 (1 pieces), given to a/two");
  CHECK(std::count(scene.labels.row.begin(), scene.labels.row.end(), 0) == 1000);
}

TEST_CASE("lift: a chip on another object changes its object") {
  Scene scene = two_blocks();
  scene.block({0, 0, 2}, 10, 10, 10, 3);
  scene.block({0.22f, 0.22f, 2.5f}, 2, 2, 1, 0);  // on top of it
  scene.join();
  CHECK(scene.last() == 3);
  CHECK(scene.labels.object.back() == 1);
}

TEST_CASE("lift: a chip in mid-air is left and reported") {
  Scene scene = two_blocks();
  scene.block({0.2f, 0.2f, 0.8f}, 2, 2, 1, 0);  // 0.35 above part one
  const Islands islands = scene.join();
  CHECK(scene.last() == 0);
  CHECK(scene.labels.confidence.back() == 0.9f);
  CHECK(islands.apart == 4);
  CHECK(islands.apart_pieces == 1);
  CHECK(islands.given == 0);
  REQUIRE(islands.omitted.size() == 1);
  CHECK(islands.omitted[0].why == "Gaussians in small pieces apart from it: 4 (1 pieces), left, as they touch nothing");
  // Leftovers are no body that one could belong to, nor do they have islands.
  scene.block({0.2f, 0.2f, 0.85f}, 20, 2, 1, 2);
  scene.block({-1, -1, -1}, 1, 1, 1, 2);
  CHECK(scene.join().apart == 4);
}

TEST_CASE("lift: a chip that is nearer to its own row than to another one stays") {
  Scene scene = two_blocks();
  scene.block({0.2f, 0.2f, 0.53f}, 2, 2, 1, 0);  // 0.08 above part one
  scene.block({0, 0, 0.62f}, 10, 10, 4, 1);      // 0.09 above the chip
  CHECK(scene.join().omitted.empty());
  CHECK(std::count(scene.labels.row.begin(), scene.labels.row.end(), 0) == 1004);
}

TEST_CASE("lift: within a cell, or in many pieces of like size, there is no island") {
  Scene near = two_blocks();
  near.block({0.2f, 0.2f, 0.54f}, 2, 2, 1, 0);  // a gap of 0.09
  CHECK(near.join().omitted.empty());
  // Candles in a cake: twenty-four pieces of 4 % each.
  Scene candles;
  candles.block({0, 0, 0}, 40, 40, 4, 1);
  for (int i = 0; i < 24; ++i) candles.block({0.3f * (i % 6), 0.4f * (i / 6), 0.2f}, 1, 1, 8, 0);
  CHECK(candles.join().omitted.empty());
}

TEST_CASE("lift: where a row is sparse, its own spacing tells the pieces") {
  Scene sparse;
  for (int i = 0; i < 400; ++i) sparse.block({0.18f * (i % 20), 0.18f * (i / 20), 0}, 1, 1, 1, 0);
  CHECK(sparse.join().omitted.empty());
}

TEST_CASE("lift: a piece touches what most of its Gaussians touch, whatever the thread count") {
  const auto joined = [](int threads) {
    omp_set_num_threads(threads);
    Scene scene = two_blocks();
    scene.block({1.2f, 0, 0}, 10, 10, 10, 3);
    // A bridge of part one between two and b, mostly on b: 0.95 is the end of two, 1.2 the start of b.
    scene.block({1.02f, 0.2f, 0.2f}, 4, 1, 1, 0);
    scene.join();
    return scene.labels.row;
  };
  const int threads = omp_get_max_threads();
  const auto one = joined(1), four = joined(4);
  omp_set_num_threads(threads);
  CHECK(one == four);
  CHECK(one.back() == 3);
}
