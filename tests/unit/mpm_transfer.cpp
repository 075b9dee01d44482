// Transfers between particles and grid against plain loops over the stencil, and the threads' order of blocks.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <set>

#include "mpm/blocks.h"
#include "mpm/grid_exchange.h"
#include "mpm/team.h"

using namespace physmas::mpm;

namespace {

// Nodes of a block and all around it that its particles may reach.
template <class T>
struct Nodes {
  GridLayout layout{12};
  std::vector<T> numbers = std::vector<T>(layout.numbers() + 16, T(0));
  T* block() { return numbers.data() + layout.offset(4, 4, 4); }
  T& at(int x, int y, int z, int k) { return numbers[layout.offset(4 + x, 4 + y, 4 + z) + k]; }
};

// A register of particles, four in each of some cells along z from (1, 2, 0), of which the lanes in `strayed` are
// elsewhere.
template <class T>
Vec3<Lanes<T>> positions(LaneBits strayed, std::mt19937& random) {
  std::uniform_real_distribution<T> inside(0, 1), anywhere(-0.4, 5.4);
  Vec3<Lanes<T>> x;
  for (int l = 0; l < kLanes<T>; ++l) {
    const bool stray = strayed >> l & 1;
    const T cell[3] = {T(1.5), T(2.5), T(0.5 + l / 4)};
    for (int axis = 0; axis < 3; ++axis) x[axis][l] = stray ? anywhere(random) : cell[axis] + inside(random);
  }
  return x;
}

constexpr int kCell = (1 * kBlock + 2) * kBlock;

// Calls function(x, y, z, weight, node - centre node [3]) for the 27 nodes of lane l.
template <class T, class Function>
void for_each_node(const Place<Lanes<T>>& at, int l, const Function& function) {
  for (int i = 0; i < 27; ++i) {
    const int step[3] = {i / 9, i / 3 % 3, i % 3};
    double weight = 1, from_center[3];
    int node[3];
    for (int axis = 0; axis < 3; ++axis) {
      weight *= at.weight[axis][step[axis]][l];
      from_center[axis] = step[axis] - 1;
      node[axis] = static_cast<int>(at.base[axis][l]) + step[axis];
    }
    function(node[0], node[1], node[2], weight, from_center);
  }
}

template <class T>
void check_gather(int column, LaneBits strayed, double tolerance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<T> number(-1, 1);
  Nodes<T> nodes;
  for (T& n : nodes.numbers) n = number(random);
  const auto at = place_of(positions<T>(strayed, random));
  GridExchange<T> exchange(nodes.layout);
  Vec3<Lanes<T>> v;
  Mat3<Lanes<T>> moment;
  exchange.gather(nodes.block(), at, column, (LaneBits(1) << kLanes<T>)-1, v, moment);
  double worst = 0;
  for (int l = 0; l < kLanes<T>; ++l) {
    double sum[3] = {}, first[3][3] = {};
    for_each_node<T>(at, l, [&](int x, int y, int z, double w, const double* d) {
      for (int a = 0; a < 3; ++a) {
        sum[a] += w * nodes.at(x, y, z, 1 + a);
        for (int b = 0; b < 3; ++b) first[a][b] += w * d[b] * nodes.at(x, y, z, 1 + a);
      }
    });
    for (int a = 0; a < 3; ++a) {
      worst = std::max(worst, std::abs(sum[a] - v[a][l]));
      for (int b = 0; b < 3; ++b) worst = std::max(worst, std::abs(first[a][b] - moment[a][b][l]));
    }
  }
  CHECK(worst < tolerance);
}

template <class T>
void check_scatter(int column, LaneBits strayed, double tolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<T> number(-1, 1);
  Nodes<T> nodes, expected;
  const auto at = place_of(positions<T>(strayed, random));
  Lanes<T> mass([&](int) { return 1 + number(random) / 2; });
  Vec3<Lanes<T>> momentum;
  Mat3<Lanes<T>> Q;
  for (int a = 0; a < 3; ++a) {
    momentum[a] = Lanes<T>([&](int) { return number(random); });
    for (int b = 0; b < 3; ++b) Q[a][b] = Lanes<T>([&](int) { return number(random); });
  }
  GridExchange<T> exchange(nodes.layout);
  exchange.scatter(nodes.block(), at, column, (LaneBits(1) << kLanes<T>)-1, mass, momentum, Q);
  exchange.flush(nodes.block());
  for (int l = 0; l < kLanes<T>; ++l) {
    for_each_node<T>(at, l, [&](int x, int y, int z, double w, const double* d) {
      expected.at(x, y, z, 0) += T(w * mass[l]);
      for (int a = 0; a < 3; ++a) {
        expected.at(x, y, z, 1 + a) +=
            T(w * (momentum[a][l] + Q[a][0][l] * d[0] + Q[a][1][l] * d[1] + Q[a][2][l] * d[2]));
      }
    });
  }
  double worst = 0;
  for (size_t i = 0; i < nodes.numbers.size(); ++i) {
    worst = std::max(worst, std::abs(double(nodes.numbers[i]) - double(expected.numbers[i])));
  }
  CHECK(worst < tolerance);
  CHECK(exchange.strays() == (column < 0 ? 0 : __builtin_popcount(strayed)));
}

}  // namespace

TEST_CASE("mpm transfer: columns, strays among them and particles one by one agree with plain loops") {
  // Sums of some tens of numbers of size one: a few roundings of the largest.
  const double single = 4e-6, full = 1e-14;
  for (const LaneBits strayed : {0u, 1u, 0x24u, 0xffu}) {
    // Positions that stray may by chance lie in their column's cell, where they do not count as strays; 5.8 cells an
    // axis make that rare, and these seeds have none.
    for (const int column : {-1, kColumnCells<float> >= 2 ? kCell : -1}) {
      check_gather<float>(column, strayed, single);
      check_scatter<float>(column, strayed, single);
    }
    for (const int column : {-1, kColumnCells<double> >= 2 ? kCell : -1}) {
      const LaneBits of_double = strayed & ((LaneBits(1) << kLanes<double>)-1);
      check_gather<double>(column, of_double, full);
      check_scatter<double>(column, of_double, full);
    }
  }
}

TEST_CASE("mpm blocks: every block is in the order once, after the neighbours that it waits for in its own range") {
  BlockMap map(64);
  std::vector<int> ids;
  for (int x = 2; x < 9; ++x)
    for (int y = 3; y < 8; ++y)
      for (int z = 1; z < 7; ++z)
        if ((x * y + z) % 5 != 0) ids.push_back(map.block_id(x, y, z));
  map.start(ids);
  for (ParticleBlock& block : map.particle_blocks) {
    block.slots = 16;
    for (int axis = 0; axis < 3; ++axis) block.low[axis] = -1, block.high[axis] = 6;
  }
  const int count = static_cast<int>(map.particle_blocks.size());
  for (const int threads : {1, 2, 3}) {
    map.connect(threads);
    REQUIRE(static_cast<int>(map.order_bounds.size()) == threads + 1);
    CHECK(map.order_bounds.back() == count);
    CHECK(std::set<int>(map.order.begin(), map.order.end()).size() == static_cast<size_t>(count));
    std::vector<int> place(count);
    for (int k = 0; k < count; ++k) place[map.order[k]] = k;
    const auto range_of = [&](int k) {
      int t = 0;
      while (map.order_bounds[t + 1] <= k) ++t;
      return t;
    };
    for (int b = 0; b < count; ++b) {
      // Of two neighbours exactly one waits for the other.
      for (int other = 0; other < count; ++other) {
        bool near = other != b;
        for (int axis = 0; axis < 3; ++axis) {
          const int* p = map.particle_blocks[b].position;
          near = near && std::abs(p[axis] - map.particle_blocks[other].position[axis]) <= 1;
        }
        const auto waits = [&](int of, int on) {
          const std::vector<int>& w = map.waits_for[of];
          return std::find(w.begin(), w.end(), on) != w.end();
        };
        REQUIRE(waits(b, other) + waits(other, b) == (near ? 1 : 0));
        if (waits(b, other) && range_of(place[b]) == range_of(place[other])) CHECK(place[other] < place[b]);
      }
    }
  }
}

TEST_CASE("mpm team: every call is made once, and calls may wait for calls of other ranges that precede them") {
  for (const int threads : {1, 2, 3}) {
    Team team(threads);
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
          for (int round = 0; stage[other] < stage[i] && calls[other] == 0; ++round) Team::pause(round);
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
