// Transfers between particles and grid against plain loops over the stencil, and the threads' order of blocks.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "mpm/cpu/block_layout.h"
#include "mpm/cpu/blocks.h"
#include "mpm/cpu/grid_exchange.h"

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

// Positions of registers of particles, as the solver keeps them: numbers of an axis one after the other.
template <class T>
struct Registers {
  static constexpr int W = kLanes<T>, kCount = kColumnBatch;
  alignas(64) T x[kCount][3 * W];
  const T* begin[kCount];

  // Four particles in each of some cells along z from (1, 2, 0); or anywhere in the block's reach.
  Registers(bool in_column, std::mt19937& random) {
    std::uniform_real_distribution<T> inside(0, 1), anywhere(-0.4, 5.4);
    for (int r = 0; r < kCount; ++r) {
      begin[r] = x[r];
      for (int l = 0; l < W; ++l) {
        const T cell[3] = {T(1.5), T(2.5), T(0.5 + l / 4)};
        for (int axis = 0; axis < 3; ++axis) {
          x[r][axis * W + l] = in_column ? cell[axis] + inside(random) : anywhere(random);
        }
      }
    }
  }
};

constexpr int kCell = (1 * kBlock + 2) * kBlock;

// Calls function(x, y, z, weight, node - centre node [3], node - particle [3]) for the 27 nodes of lane l.
template <class T, class Function>
void for_each_node(const T* x, int l, const Function& function) {
  for (int i = 0; i < 27; ++i) {
    const int step[3] = {i / 9, i / 3 % 3, i % 3};
    double weight = 1, from_center[3], from_particle[3];
    int node[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double here = x[axis * kLanes<T> + l], base = std::floor(here - 0.5), f = here - base;
      const double w[3] = {0.5 * (1.5 - f) * (1.5 - f), 0.75 - (f - 1) * (f - 1), 0.5 * (f - 0.5) * (f - 0.5)};
      weight *= w[step[axis]];
      from_center[axis] = step[axis] - 1;
      from_particle[axis] = step[axis] - f;
      node[axis] = static_cast<int>(base) + step[axis];
    }
    function(node[0], node[1], node[2], weight, from_center, from_particle);
  }
}

// count: registers of a column, or 0: one register of particles anywhere. lanes: those with particles.
template <class T>
void check_gather(int count, LaneBits lanes, double tolerance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<T> number(-1, 1);
  Nodes<T> nodes;
  for (T& n : nodes.numbers) n = number(random);
  const Registers<T> particles(count > 0, random);
  const GridExchange<T> exchange(nodes.layout);
  GridNumbers<T> out[kColumnBatch];
  if (count > 0) {
    const LaneBits held[kColumnBatch] = {lanes, lanes, lanes, lanes};
    exchange.gather_columns(nodes.block(), kCell, count, particles.begin, held, out);
  } else {
    exchange.gather_particles(nodes.block(), particles.x[0], lanes, out[0]);
  }
  double worst = 0;
  for (int r = 0; r < std::max(count, 1); ++r) {
    for (int l = 0; l < kLanes<T>; ++l) {
      double sum[3] = {}, first[3][3] = {};
      if (lanes >> l & 1) {
        for_each_node(particles.x[r], l, [&](int x, int y, int z, double w, const double*, const double* d) {
          for (int a = 0; a < 3; ++a) {
            sum[a] += w * nodes.at(x, y, z, 1 + a);
            for (int b = 0; b < 3; ++b) first[a][b] += w * d[b] * nodes.at(x, y, z, 1 + a);
          }
        });
      }
      for (int a = 0; a < 3; ++a) {
        worst = std::max(worst, std::abs(sum[a] - out[r].number[out->vector(a)][l]));
        for (int b = 0; b < 3; ++b)
          worst = std::max(worst, std::abs(first[a][b] - out[r].number[out->matrix(a, b)][l]));
      }
    }
  }
  CHECK(worst < tolerance);
}

template <class T>
void check_scatter(int count, LaneBits lanes, double tolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<T> number(-1, 1);
  Nodes<T> nodes, expected;
  const Registers<T> particles(count > 0, random);
  GridNumbers<T> in[kColumnBatch];
  const auto random_lanes = [&] { return Lanes<T>([&](int l) { return lanes >> l & 1 ? number(random) : T(0); }); };
  for (int r = 0; r < std::max(count, 1); ++r) {
    const auto axis = [&](int a) { return Lanes<T>(particles.x[r] + a * kLanes<T>, stdx::vector_aligned); };
    const Vec3<Lanes<T>> x = {axis(0), axis(1), axis(2)};
    in[r].set_weights(place_of(x, count > 0 ? GridExchange<T>::column_base(kCell) : base_of(x)));
    Vec3<Lanes<T>> P;
    Mat3<Lanes<T>> Q;
    for (int a = 0; a < 3; ++a) {
      P[a] = random_lanes();
      for (int b = 0; b < 3; ++b) Q[a][b] = random_lanes();
    }
    in[r].set(random_lanes(), P, Q);
    for (int l = 0; l < kLanes<T>; ++l) {
      for_each_node(particles.x[r], l, [&](int nx, int ny, int nz, double w, const double* d, const double*) {
        const auto lane = [&](int k) { return double(in[r].number[k][l]); };
        expected.at(nx, ny, nz, 0) += T(w * lane(in->kMass));
        for (int a = 0; a < 3; ++a) {
          expected.at(nx, ny, nz, 1 + a) += T(w * (lane(in->vector(a)) + lane(in->matrix(a, 0)) * d[0] +
                                                   lane(in->matrix(a, 1)) * d[1] + lane(in->matrix(a, 2)) * d[2]));
        }
      });
    }
  }
  const GridExchange<T> exchange(nodes.layout);
  if (count > 0) {
    exchange.scatter_columns(nodes.block(), kCell, count, in);
  } else {
    exchange.scatter_particles(nodes.block(), particles.x[0], lanes, in[0]);
  }
  double worst = 0;
  for (size_t i = 0; i < nodes.numbers.size(); ++i) {
    worst = std::max(worst, std::abs(double(nodes.numbers[i]) - double(expected.numbers[i])));
  }
  CHECK(worst < tolerance);
}

template <class T>
void check_transfers(LaneBits lanes, double tolerance) {
  for (int count = 0; count <= (kColumnCells<T> >= 2 ? kColumnBatch : 0); ++count) {
    CAPTURE(count);
    check_gather<T>(count, lanes & kAllLanes<T>, tolerance);
    check_scatter<T>(count, lanes & kAllLanes<T>, tolerance);
  }
}

}  // namespace

TEST_CASE("mpm transfer: batches of columns and particles one by one agree with plain loops") {
  // Sums of some tens of numbers of size one: a few roundings of the largest.
  for (const LaneBits lanes : {0xffffu, 0xfffeu, 0x7f2bu, 0x0010u}) {
    CAPTURE(lanes);
    check_transfers<float>(lanes, 4e-6);
    check_transfers<double>(lanes, 1e-14);
  }
}

TEST_CASE("mpm transfer: a particle that has left its column's cell is seen") {
  const LaneBits all = kAllLanes<float>;
  std::mt19937 random(7);
  Registers<float> particles(true, random);
  float* const x = particles.x[0];
  const auto seen = [&] {
    const auto axis = [&](int a) { return Lanes<float>(x + a * kLanes<float>, stdx::vector_aligned); };
    return lane_bits(strayed(
               place_of(Vec3<Lanes<float>>{axis(0), axis(1), axis(2)}, GridExchange<float>::column_base(kCell)))) &
           all;
  };
  CHECK(seen() == 0);
  for (int axis = 0; axis < 3; ++axis) {
    float& place = x[axis * kLanes<float> + kLanes<float> / 2];
    const float before = place;
    for (const float elsewhere : {before + 1.01f, before - 1.01f, std::nanf("")}) {
      place = elsewhere;
      CHECK(seen() == LaneBits(1) << kLanes<float> / 2);
    }
    place = before;
  }
}

TEST_CASE(
    "mpm blocks: every block is in the order once, after the neighbours that its run waits for in its own range") {
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
    const int runs = static_cast<int>(map.run_bounds.size()) - 1;
    REQUIRE(static_cast<int>(map.thread_bounds.size()) == threads + 1);
    CHECK(map.thread_bounds.back() == runs);
    CHECK(map.run_bounds.back() == count);
    CHECK(std::set<int>(map.order.begin(), map.order.end()).size() == static_cast<size_t>(count));
    std::vector<int> place(count);
    for (int k = 0; k < count; ++k) place[map.order[k]] = k;
    const auto part_of = [](const std::vector<int>& bounds, int k) {
      return static_cast<int>(std::upper_bound(bounds.begin(), bounds.end(), k) - bounds.begin()) - 1;
    };
    const auto run_of = [&](int b) { return part_of(map.run_bounds, place[b]); };
    const auto range_of = [&](int b) { return part_of(map.thread_bounds, run_of(b)); };
    for (int b = 0; b < count; ++b) {
      // Of two neighbours exactly one waits for the other, or they lie in one run.
      for (int other = 0; other < count; ++other) {
        bool near = other != b;
        for (int axis = 0; axis < 3; ++axis) {
          const int* p = map.particle_blocks[b].position;
          near = near && std::abs(p[axis] - map.particle_blocks[other].position[axis]) <= 1;
        }
        const auto waits = [&](int of, int on) {
          const std::vector<int>& w = map.waits_for[run_of(of)];
          return std::find(w.begin(), w.end(), run_of(on)) != w.end();
        };
        const bool one_run = run_of(b) == run_of(other);
        REQUIRE(waits(b, other) + waits(other, b) <= (one_run ? 0 : 1));
        if (near && !one_run) REQUIRE(waits(b, other) + waits(other, b) == 1);
        if (waits(b, other) && range_of(b) == range_of(other)) CHECK(place[other] < place[b]);
        if (one_run && other < b) CHECK(place[other] < place[b]);
      }
    }
  }
}

TEST_CASE("mpm block layout: every particle has one slot, and those in columns lie in their cell and share a row") {
  constexpr int W = 16, kCells = W / kColumnSlots;
  std::mt19937 random(11);
  BlockLayout<W> layout;  // used again, as the solver does
  for (const auto& [rows, bodies] : {std::pair(1, 1), std::pair(3, 1), std::pair(3, 2)}) {
    for (const int count : {1, 15, 200, 600}) {
      CAPTURE(rows);
      CAPTURE(bodies);
      CAPTURE(count);
      std::vector<Arrival> arrivals;
      for (int k = 0; k < count; ++k) {
        arrivals.push_back({k, static_cast<int>(random() % rows), static_cast<std::uint8_t>(random() % 48), 13});
      }
      ParticleBlock block;
      block.count = count;
      BodyContact contact;  // of three rows, the first and the last are one body
      if (bodies > 1) contact.body = {0, 1, 0};
      layout.lay_out(arrivals.data(), contact, block);
      if (count > 15) CHECK(block.bodies == (1u << bodies) - 1);
      REQUIRE(layout.from.size() == static_cast<size_t>(block.slots));
      REQUIRE(layout.column.size() * W == static_cast<size_t>(block.slots));
      std::vector<int> held(count);
      for (int slot = 0; slot < block.slots; ++slot) {
        if (layout.from[slot] >= 0) ++held[layout.from[slot]];
      }
      CHECK(*std::min_element(held.begin(), held.end()) == 1);
      CHECK(*std::max_element(held.begin(), held.end()) == 1);
      int columns = 0;
      for (int r = 0; r < block.slots / W; ++r) {
        CHECK((layout.column[r] < 0) == (r < block.loose));
        std::set<int> bodies_here;
        for (int l = 0; l < W; ++l) {
          const int k = layout.from[r * W + l];
          if (k >= 0) bodies_here.insert(contact.of(arrivals[k].row));
        }
        CHECK(bodies_here.size() <= 1);
        if (layout.column[r] < 0) continue;
        ++columns;
        int filled = 0, wrong = 0;
        std::set<int> rows_here;
        for (int l = 0; l < W; ++l) {
          const int k = layout.from[r * W + l];
          if (k < 0) continue;
          ++filled;
          wrong += arrivals[k].cell != layout.column[r] + l / kColumnSlots;
          rows_here.insert(arrivals[k].row);
        }
        CHECK(layout.column[r] % kCells == 0);
        CHECK(wrong == 0);
        CHECK(rows_here.size() == 1);
        CHECK(filled >= BlockLayout<W>::kLeastFilled);
      }
      CHECK((columns > 0) == (count == 600 || (count == 200 && rows == 1)));
      // Cells 0 to 47 are the planes x = 0 to 2, which reach one node less and three more.
      CHECK(block.low[0] >= -1);
      CHECK(block.high[0] <= 2 + 3);
    }
  }
}
