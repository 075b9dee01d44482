#include "mpm/stepper.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "base/clock.h"
#include "mpm/blocks.h"
#include "mpm/collider.h"
#include "mpm/constitutive.h"
#include "mpm/row.h"

namespace physmas::mpm {

namespace {

// Particles stay this many cells away from the edge of the grid, inside the domain walls: every node of a stencil
// exists.
constexpr double kSafeCells = 2;
// A sort is due before particles could drift this far [cells]: the arenas leave room for one cell.
constexpr double kDriftLimit = 0.999;
// Zeroed memory, aligned to a cache line. Pages that are never touched cost nothing, so a dense table of grid blocks
// only uses memory where material has been.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  ~Buffer() { std::free(raw_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  // Contents are lost when the buffer grows.
  void resize(size_t count) {
    size_ = count;
    if (count <= capacity_) return;
    std::free(raw_);
    capacity_ = count + count / 8;
    raw_ = std::calloc(capacity_ * sizeof(T) + 128, 1);
    if (!raw_) throw std::bad_alloc();
    data_ = reinterpret_cast<T*>((reinterpret_cast<std::uintptr_t>(raw_) + 63) / 64 * 64);
  }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](size_t i) { return data_[i]; }
  const T& operator[](size_t i) const { return data_[i]; }
  size_t size() const { return size_; }
  void swap(Buffer& other) {
    std::swap(raw_, other.raw_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

 private:
  void* raw_ = nullptr;
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

// What one block reports from one pass; summed in block order, so totals do not depend on the threads.
struct BlockReport {
  double kinetic = 0;       // J
  double control_work = 0;  // J
  double max_speed_squared = 0;
  int clamped = 0;
  bool not_finite = false;
};

template <class T>
class TypedStepper final : public Stepper {
 public:
  explicit TypedStepper(const StepperSetup& setup);
  long long load(const State& state) override;
  void store(State& state) const override;
  StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) override;
  int active_grid_blocks() const override { return static_cast<int>(map_.grid_blocks.size()); }

 private:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;
  static_assert(W == Row<T>::kPart);
  static constexpr int kFields = 12;  // x 3, F 9: what lives from substep to substep

  // Controls of one substep in this precision.
  struct ControlTable {
    bool active = false;
    std::vector<Control> group;
  };
  struct Scratch;

  void resort(StepReport& report);
  void refresh_groups();
  template <bool kGather, bool kScatter>
  void pass(double dt, StepReport& report);
  template <bool kGather, bool kScatter>
  void process_block(int block, double dt);
  void grid_update(double dt, StepReport& report);
  double update_grid_block(const GridBlock& block, double dt);
  void load_arena(const ParticleBlock& block, T* arena) const;
  MaterialParameters<V> group_parameters(int group, int first) const;
  Mat3<V> update_stress(int group, int first, const MaterialParameters<V>& p, const V& dt, Mat3<V>& F,
                        V& strength) const;
  bool near_obstacle(const GridBlock& block) const;

  StepperSetup setup_;
  double dx_;
  bool uses_strength_ = false;
  std::vector<MaterialParameters<T>> parameters_;

  // Slots: particles in sorted order, in groups of W lanes.
  BlockMap map_;
  int slots_ = 0;
  Buffer<T> field_[kFields], field_back_[kFields];  // x in cells from the block's first node; F row-major
  Buffer<T> volume_, volume_back_, strength_, strength_back_;
  Buffer<int> particle_, particle_back_;        // -1: empty slot
  Buffer<T> v_[3], C_[9];                       // valid between intervals only
  std::vector<int> group_row_;                  // row of all lanes of a group, -1 when mixed
  std::vector<std::uint8_t> group_controlled_;  // whether any lane is in a control group

  // Grid. Velocities lie in blocks of 4^3 nodes of {0, vx, vy, vz}; arenas collect {m, m vx, m vy, m vz}.
  Buffer<T> velocity_;
  Buffer<T> arenas_;
  std::vector<std::uint8_t> obstacle_;  // per active grid block: a wall or collider may touch it
  std::vector<double> grid_speed_;      // per active grid block: largest velocity component [m/s]
  std::vector<BlockReport> reports_;    // per particle block

  double drift_ = 0;             // cells since the last sort, at most
  double next_drift_ = 0;        // cells in the coming pass, at most
  double kinetic_ = 0;           // J, of the last gathered substep
  ControlTable before_, after_;  // of the substep that is scattered, of the one that was gathered
};

// T numbers per arena; the last row of a stencil may be read four numbers further.
constexpr size_t kArenaNumbers = 4 * kArenaNodes + 16;

template <class T>
struct TypedStepper<T>::Scratch {
  alignas(64) T arena[kArenaNumbers];
  alignas(64) T record[W][16];
  alignas(64) T weight[9][W];  // three along x, y and z
  alignas(64) T lanes[16][W];
  int offset[W];
};

template <class T>
TypedStepper<T>::TypedStepper(const StepperSetup& setup)
    : setup_(setup), dx_(setup.domain.dx()), map_(setup.domain.n + 1, W) {
  for (const auto& p : setup_.parameters) parameters_.push_back(convert_parameters<T>(p));
  for (const int row : setup_.row) uses_strength_ = uses_strength_ || setup_.branches[row] == Branch::plasticine;
  velocity_.resize(static_cast<size_t>(map_.grid_block_count()) * kBlockNodes * 4);
}

template <class T>
long long TypedStepper<T>::load(const State& state) {
  const int count = static_cast<int>(state.size());
  const double low = kSafeCells, high = setup_.domain.n - kSafeCells;
  std::vector<int> base(3 * static_cast<size_t>(count));
  std::vector<Vec3d> cells(count);
  long long clamped = 0;
  for (int i = 0; i < count; ++i) {
    bool moved = false;
    for (int axis = 0; axis < 3; ++axis) {
      const double x = state.x[i][axis] / dx_;
      const double inside = at_most(at_least(x, low), high);
      moved = moved || inside != x;
      cells[i][axis] = inside;
      base[3 * static_cast<size_t>(i) + axis] = static_cast<int>(std::floor(inside - 0.5));
    }
    clamped += moved;
  }
  map_.sort(base);
  slots_ = static_cast<int>(map_.source.size());
  for (auto& f : field_) f.resize(slots_);
  for (auto& f : v_) f.resize(slots_);
  for (auto& f : C_) f.resize(slots_);
  volume_.resize(slots_);
  particle_.resize(slots_);
  if (uses_strength_) strength_.resize(slots_);
  for (const ParticleBlock& block : map_.particle_blocks) {
    const int end = block.begin + (block.count + W - 1) / W * W;
    for (int s = block.begin; s < end; ++s) {
      const int i = map_.source[s];
      const bool real = i >= 0;
      particle_[s] = i;
      volume_[s] = real ? T(setup_.volume[i]) : T(0);
      if (uses_strength_) strength_[s] = real ? T(state.strength[i]) : T(1);
      for (int a = 0; a < 3; ++a) {
        field_[a][s] = real ? T(cells[i][a] - kBlock * block.position[a]) : T(2);
        v_[a][s] = real ? T(state.v[i][a]) : T(0);
        for (int b = 0; b < 3; ++b) {
          field_[3 + 3 * a + b][s] = real ? T(state.F[i][a][b]) : T(a == b);
          C_[3 * a + b][s] = real ? T(state.C[i][a][b]) : T(0);
        }
      }
    }
  }
  refresh_groups();
  return clamped;
}

template <class T>
void TypedStepper<T>::store(State& state) const {
  for (const ParticleBlock& block : map_.particle_blocks) {
    for (int s = block.begin; s < block.begin + block.count; ++s) {
      const int i = particle_[s];
      for (int a = 0; a < 3; ++a) {
        state.x[i][a] = (double(field_[a][s]) + kBlock * block.position[a]) * dx_;
        state.v[i][a] = v_[a][s];
        for (int b = 0; b < 3; ++b) {
          state.F[i][a][b] = field_[3 + 3 * a + b][s];
          state.C[i][a][b] = C_[3 * a + b][s];
        }
      }
      if (uses_strength_) state.strength[i] = strength_[s];
    }
  }
}

// After a sort: what depends on the order of the slots or on the set of active blocks.
template <class T>
void TypedStepper<T>::refresh_groups() {
  drift_ = 0;
  group_row_.assign(slots_ / W, -1);
  group_controlled_.assign(slots_ / W, 0);
  for (int g = 0; g < slots_ / W; ++g) {
    int row = setup_.row[particle_[g * W]];
    for (int l = 0; l < W; ++l) {
      const int i = particle_[g * W + l];
      if (i < 0) continue;
      if (setup_.row[i] != row) row = -1;
      group_controlled_[g] |= setup_.control_group[i] != 0;
    }
    group_row_[g] = row;
  }
  arenas_.resize(map_.particle_blocks.size() * kArenaNumbers);
  reports_.assign(map_.particle_blocks.size(), {});
  grid_speed_.assign(map_.grid_blocks.size(), 0);
  obstacle_.assign(map_.grid_blocks.size(), 0);
  for (size_t b = 0; b < obstacle_.size(); ++b) obstacle_[b] = near_obstacle(map_.grid_blocks[b]);
}

template <class T>
bool TypedStepper<T>::near_obstacle(const GridBlock& block) const {
  const int last_free = setup_.domain.n - setup_.domain.wall_cells;
  Vec3d center{};
  for (int axis = 0; axis < 3; ++axis) {
    const int first = kBlock * block.position[axis];
    if (first <= setup_.domain.wall_cells || first + kBlock - 1 >= last_free) return true;
    center[axis] = (first + 0.5 * (kBlock - 1)) * dx_;
  }
  const double reach = 0.5 * (kBlock - 1) * std::sqrt(3.0) * dx_ * (1 + 1e-9);
  for (const Collider& c : setup_.domain.colliders) {
    if (locate(c, center).distance <= reach) return true;
  }
  return false;
}

// Puts the particles into new blocks. Needs no velocities: it happens between the grid update and the next gather.
template <class T>
void TypedStepper<T>::resort(StepReport& report) {
  const Stopwatch watch;
  const std::vector<ParticleBlock> old_blocks = map_.particle_blocks;
  const int count = static_cast<int>(setup_.row.size());
  std::vector<int> base(3 * static_cast<size_t>(count)), slot(count);
  std::vector<int> block_of(count);
  size_t k = 0;
  for (size_t b = 0; b < old_blocks.size(); ++b) {
    for (int s = old_blocks[b].begin; s < old_blocks[b].begin + old_blocks[b].count; ++s, ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        base[3 * k + axis] =
            static_cast<int>(std::floor(field_[axis][s] - T(0.5))) + kBlock * old_blocks[b].position[axis];
      }
      slot[k] = s;
      block_of[k] = static_cast<int>(b);
    }
  }
  map_.sort(base);
  slots_ = static_cast<int>(map_.source.size());
  for (auto& f : field_back_) f.resize(slots_);
  volume_back_.resize(slots_);
  particle_back_.resize(slots_);
  if (uses_strength_) strength_back_.resize(slots_);
  for (auto& f : v_) f.resize(slots_);
  for (auto& f : C_) f.resize(slots_);
  const int blocks = static_cast<int>(map_.particle_blocks.size());
  setup_.team->for_each(blocks, [&](int b) {
    const ParticleBlock& block = map_.particle_blocks[b];
    const int end = block.begin + (block.count + W - 1) / W * W;
    for (int s = block.begin; s < end; ++s) {
      const int from = map_.source[s];
      const int old = from >= 0 ? slot[from] : -1;
      particle_back_[s] = old >= 0 ? particle_[old] : -1;
      volume_back_[s] = old >= 0 ? volume_[old] : T(0);
      if (uses_strength_) strength_back_[s] = old >= 0 ? strength_[old] : T(1);
      for (int f = 0; f < kFields; ++f) {
        field_back_[f][s] = old >= 0 ? field_[f][old] : f < 3 ? T(2) : T(f == 3 || f == 7 || f == 11);
      }
      if (old < 0) continue;
      // From one block's origin to another: a whole number of cells.
      for (int axis = 0; axis < 3; ++axis) {
        field_back_[axis][s] += T(kBlock * (old_blocks[block_of[from]].position[axis] - block.position[axis]));
      }
    }
  });
  for (int f = 0; f < kFields; ++f) field_[f].swap(field_back_[f]);
  volume_.swap(volume_back_);
  particle_.swap(particle_back_);
  strength_.swap(strength_back_);
  refresh_groups();
  ++report.sorts;
  report.seconds_sort += watch.seconds();
}

// ---- Grid.

// Sums the arenas that reach a block of nodes in a fixed order, turns momentum into velocity and applies gravity,
// colliders and walls. Returns the largest velocity component [m/s].
template <class T>
double TypedStepper<T>::update_grid_block(const GridBlock& block, double dt) {
  typedef T Quad __attribute__((vector_size(4 * sizeof(T))));
  alignas(64) Quad node[kBlock][kBlock][kBlock] = {};
  for (int k = block.parts_begin; k < block.parts_end; ++k) {
    const ArenaPart& part = map_.parts[k];
    const T* arena = arenas_.data() + static_cast<size_t>(part.arena) * kArenaNumbers;
    for (int x = part.low[0]; x <= part.high[0]; ++x) {
      for (int y = part.low[1]; y <= part.high[1]; ++y) {
        const T* row = arena + 4 * (((x + part.offset[0]) * kArena + y + part.offset[1]) * kArena + part.offset[2]);
        for (int z = part.low[2]; z <= part.high[2]; ++z) {
          Quad q;
          std::memcpy(&q, row + 4 * z, sizeof(q));
          node[x][y][z] += q;
        }
      }
    }
  }
  const Vec3d& g = setup_.domain.gravity;
  const Quad fall = {T(0), T(dt * g.x), T(dt * g.y), T(dt * g.z)};
  T* out = velocity_.data() + static_cast<size_t>(block.id) * kBlockNodes * 4;
  Quad* flat = &node[0][0][0];
  Quad largest = {};
  for (int i = 0; i < kBlockNodes; ++i) {
    const T mass = flat[i][0];
    Quad u = flat[i] * (mass > T(0) ? T(1) / mass : T(0)) + fall;
    u[0] = 0;
    flat[i] = u;
  }
  if (obstacle_[&block - map_.grid_blocks.data()]) {
    const int wall = setup_.domain.wall_cells, far_wall = setup_.domain.n - wall;
    for (int i = 0; i < kBlockNodes; ++i) {
      const int index[3] = {kBlock * block.position[0] + i / 16, kBlock * block.position[1] + i / 4 % 4,
                            kBlock * block.position[2] + i % 4};
      Vec3d u = {flat[i][1], flat[i][2], flat[i][3]};
      const Vec3d x = {index[0] * dx_, index[1] * dx_, index[2] * dx_};
      for (const Collider& c : setup_.domain.colliders) u = apply_contact(c, locate(c, x), u);
      for (int axis = 0; axis < 3; ++axis) {
        if (index[axis] <= wall) u[axis] = at_least(u[axis], 0.0);
        if (index[axis] >= far_wall) u[axis] = at_most(u[axis], 0.0);
      }
      flat[i] = Quad{T(0), T(u.x), T(u.y), T(u.z)};
    }
  }
  for (int i = 0; i < kBlockNodes; ++i) {
    const Quad size = flat[i] < 0 ? -flat[i] : flat[i];
    largest = size > largest ? size : largest;
  }
  std::memcpy(out, flat, sizeof(node));
  return std::max({double(largest[1]), double(largest[2]), double(largest[3])});
}

template <class T>
void TypedStepper<T>::grid_update(double dt, StepReport& report) {
  const Stopwatch watch;
  const int count = static_cast<int>(map_.grid_blocks.size());
  constexpr int kChunk = 8;  // a block alone is less than a microsecond
  setup_.team->for_each((count + kChunk - 1) / kChunk, [&](int chunk) {
    for (int b = chunk * kChunk; b < std::min(count, (chunk + 1) * kChunk); ++b) {
      grid_speed_[b] = update_grid_block(map_.grid_blocks[b], dt);
    }
  });
  double speed = 0;
  for (const double s : grid_speed_) speed = std::max(speed, s);
  // Particle velocities are convex combinations of node velocities, so none is faster than the fastest node.
  next_drift_ = speed * dt / dx_;
  report.seconds_grid += watch.seconds();
}

template <class T>
void TypedStepper<T>::load_arena(const ParticleBlock& block, T* arena) const {
  for (int x = block.low[0]; x <= block.high[0]; ++x) {
    for (int y = block.low[1]; y <= block.high[1]; ++y) {
      // Arena node a is node (a + 3) % 4 of neighbour (a + 3) / 4 - 1.
      const int id = block.id + ((x + 3) / 4 - 1) * map_.id_stride(0) + ((y + 3) / 4 - 1) * map_.id_stride(1);
      const T* from = velocity_.data() + static_cast<size_t>(id) * kBlockNodes * 4 +
                      4 * kBlock * (kBlock * ((x + 3) % 4) + (y + 3) % 4);
      T* to = arena + 4 * kArena * (kArena * x + y);
      std::memcpy(to, from - 4 * kBlockNodes + 12, 4 * sizeof(T));
      std::memcpy(to + 4, from, 16 * sizeof(T));
      std::memcpy(to + 20, from + 4 * kBlockNodes, 12 * sizeof(T));
    }
  }
}

// ---- Particles.

// Nine rows of one particle's stencil, contracted one axis at a time. Results: velocity and the first moments
// Σ w v (node − centre node) along x, y and z in cells, four numbers each, the first of them without meaning.
template <class T>
PHYSMAS_INLINE Row<T> z_weights(const T* wz) {
  using R = Row<T>;
  return wz[0] * R::template unit<0>() + (wz[1] * R::template unit<1>() + wz[2] * R::template unit<2>());
}

// Nodes counted from the centre node along z.
template <class T>
PHYSMAS_INLINE Row<T> z_steps() {
  return Row<T>::template unit<2>() - Row<T>::template unit<0>();
}

template <class T>
PHYSMAS_INLINE void gather_particle(const T* corner, const T* wx, const T* wy, const T* wz, T* out) {
  using R = Row<T>;
  R sum[3], slope[3];
  for (int i = 0; i < 3; ++i) {
    const T* row = corner + 4 * kArena * kArena * i;
    const R low = wy[0] * R::load(row);
    const R high = wy[2] * R::load(row + 8 * kArena);
    sum[i] = wy[1] * R::load(row + 4 * kArena) + (low + high);
    slope[i] = high - low;
  }
  const R low = wx[0] * sum[0], high = wx[2] * sum[2];
  const R weight = z_weights(wz);
  const R total = (wx[1] * sum[1] + (low + high)) * weight;
  const R along_x = (high - low) * weight;
  const R along_y = (wx[0] * slope[0] + wx[1] * slope[1] + wx[2] * slope[2]) * weight;
  const R along_z = total * z_steps<T>();
  R::sums_of_nodes(total, along_x, along_y, along_z).store(out);
}

// Adds w (P + Q (node − centre node)) to nine row accumulators. record: {m, P}, and the columns of Q, four numbers
// each.
template <class T>
PHYSMAS_INLINE void scatter_particle(Row<T>* sum, const T* wx, const T* wy, const T* wz, const T* record) {
  using R = Row<T>;
  const R weight = z_weights(wz);
  const R all = R::load(record);
  const R center = (all.template repeat<0>() + z_steps<T>() * all.template repeat<3>()) * weight;
  const R x = all.template repeat<1>() * weight, y = all.template repeat<2>() * weight;
  const R plane[3] = {wx[0] * (center - x), wx[1] * center, wx[2] * (center + x)};
  for (int i = 0; i < 3; ++i) {
    const R slope = wx[i] * y;
    sum[3 * i] = wy[0] * (plane[i] - slope) + sum[3 * i];
    sum[3 * i + 1] = wy[1] * plane[i] + sum[3 * i + 1];
    sum[3 * i + 2] = wy[2] * (plane[i] + slope) + sum[3 * i + 2];
  }
}

template <class T>
PHYSMAS_INLINE void flush_rows(Row<T>* sum, T* corner) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      T* row = corner + 4 * kArena * (kArena * i + j);
      (Row<T>::load(row) + sum[3 * i + j]).store(row);
      sum[3 * i + j] = Row<T>::zero();
    }
  }
}

// Parameters of the lanes of a group: the same in all lanes unless rows are mixed.
template <class T>
MaterialParameters<typename TypedStepper<T>::V> TypedStepper<T>::group_parameters(int group, int first) const {
  const int common = group_row_[group];
  if (common >= 0) {
    const MaterialParameters<T>& p = parameters_[common];
    return {V(p.mu),       V(p.lambda), V(p.bulk),      V(p.density),   V(p.friction),      V(p.alpha),
            V(p.cohesion), V(p.yield),  V(p.viscosity), V(p.softening), V(p.residual_yield)};
  }
  alignas(64) T lanes[kMaterialParameterCount][W];
  for (int l = 0; l < W; ++l) {
    const int i = particle_[first + l];
    const int row = setup_.row[i >= 0 ? i : particle_[first]];
    T numbers[kMaterialParameterCount];
    static_assert(sizeof(numbers) == sizeof(MaterialParameters<T>));
    std::memcpy(numbers, &parameters_[row], sizeof(numbers));
    for (int k = 0; k < kMaterialParameterCount; ++k) lanes[k][l] = numbers[k];
  }
  const auto at = [&](int k) { return V(lanes[k], stdx::vector_aligned); };
  return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9), at(10)};
}

template <class T>
Mat3<typename TypedStepper<T>::V> TypedStepper<T>::update_stress(int group, int first, const MaterialParameters<V>& p,
                                                                 const V& dt, Mat3<V>& F, V& strength) const {
  const int common = group_row_[group];
  if (common >= 0) return update_branch(setup_.branches[common], p, dt, F, strength);
  // Lanes of several rows: evaluate every branch that occurs, and let each lane keep its own.
  alignas(64) T branch_of[W];
  bool present[kBranchCount] = {};
  for (int l = 0; l < W; ++l) {
    const int i = particle_[first + l];
    const int branch = static_cast<int>(setup_.branches[setup_.row[i >= 0 ? i : particle_[first]]]);
    branch_of[l] = T(branch);
    present[branch] = true;
  }
  const V lane_branch(branch_of, stdx::vector_aligned);
  const Mat3<V> trial = F;
  const V trial_strength = strength;
  Mat3<V> tau = identity<V>();
  for (int branch = 0; branch < kBranchCount; ++branch) {
    if (!present[branch]) continue;
    Mat3<V> branch_F = trial;
    V branch_strength = trial_strength;
    const Mat3<V> branch_tau = update_branch(static_cast<Branch>(branch), p, dt, branch_F, branch_strength);
    const auto mine = lane_branch == V(T(branch));
    tau = select(mine, branch_tau, tau);
    F = select(mine, branch_F, F);
    strength = select(mine, branch_strength, strength);
  }
  return tau;
}

template <class T>
template <bool kGather, bool kScatter>
void TypedStepper<T>::process_block(int index, double dt) {
  Scratch scratch;
  const ParticleBlock& block = map_.particle_blocks[index];
  T* const out = arenas_.data() + static_cast<size_t>(index) * kArenaNumbers;
  if (kGather) {
    // The fourth node of a row is read with weight zero, also where nothing was loaded.
    std::memset(scratch.arena, 0, sizeof(scratch.arena));
    load_arena(block, scratch.arena);
  }
  if (kScatter) {
    for (int x = block.low[0]; x <= block.high[0]; ++x) {
      std::memset(out + 4 * kArena * (kArena * x + block.low[1]), 0,
                  sizeof(T) * 4 * kArena * (block.high[1] - block.low[1] + 1));
    }
  }
  BlockReport report;
  const T step = T(dt);
  const T move = T(dt / dx_), gradient = T(4 / dx_);
  // Particles of blocks at the edge are held in the safe interior.
  T low[3], high[3];
  bool at_edge = false;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = T(kSafeCells - kBlock * block.position[axis]);
    high[axis] = T(setup_.domain.n - kSafeCells - kBlock * block.position[axis]);
    at_edge = at_edge || low[axis] > T(-2) || high[axis] < T(kBlock + 3);
  }
  V kinetic(T(0)), speed(T(0));
  auto finite = V(T(0)) == V(T(0));

  // Base nodes, weights and offsets of a group at its present positions. Base nodes are held inside the arena, so that
  // no number whatsoever can lead a transfer outside it; where that bites, the speed check ends the run.
  Vec3<V> to_center;
  const auto locate_group = [&](const Vec3<V>& x) {
    V base[3];
    for (int axis = 0; axis < 3; ++axis) {
      base[axis] = at_most(at_least(round_down(x[axis] - T(0.5)), V(T(-1))), V(T(kBlock)));
      const V f = x[axis] - base[axis];
      const V l = T(1.5) - f, r = f - T(0.5);
      const V w0 = T(0.5) * l * l, w2 = T(0.5) * r * r;
      const V w1 = T(1) - w0 - w2;
      to_center[axis] = T(1) - f;
      w0.copy_to(scratch.weight[3 * axis], stdx::vector_aligned);
      w1.copy_to(scratch.weight[3 * axis + 1], stdx::vector_aligned);
      w2.copy_to(scratch.weight[3 * axis + 2], stdx::vector_aligned);
    }
    const V node = (base[0] * T(kArena) + base[1]) * T(kArena) + base[2] + T(1 + kArena + kArena * kArena);
    alignas(64) T node_lanes[W];
    node.copy_to(node_lanes, stdx::vector_aligned);
    for (int l = 0; l < W; ++l) scratch.offset[l] = 4 * static_cast<int>(node_lanes[l]);
  };
  const auto weights_of = [&](int l, T* w) {
    for (int k = 0; k < 9; ++k) w[k] = scratch.weight[k][l];
  };

  Row<T> sum[9];
  for (auto& s : sum) s = Row<T>::zero();
  int corner = -1;  // arena offset that `sum` belongs to
  for (int first = block.begin; first < block.begin + block.count; first += W) {
    const int group = first / W;
    const int real = std::min(W, block.begin + block.count - first);
    Vec3<V> x;
    Mat3<V> F, C;
    Vec3<V> v;
    for (int a = 0; a < 3; ++a) {
      x[a] = V(&field_[a][first], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) F[a][b] = V(&field_[3 + 3 * a + b][first], stdx::vector_aligned);
    }
    const MaterialParameters<V> p = group_parameters(group, first);
    const V volume(&volume_[first], stdx::vector_aligned);
    const V mass = p.density * volume;
    V strength = uses_strength_ ? V(&strength_[first], stdx::vector_aligned) : V(T(1));

    if (kGather) {
      locate_group(x);
      for (int l = 0; l < real; ++l) {
        T w[9];
        weights_of(l, w);
        gather_particle(scratch.arena + scratch.offset[l], w, w + 3, w + 6, scratch.record[l]);
      }
      for (int l = real; l < W; ++l) std::memset(scratch.record[l], 0, sizeof(scratch.record[l]));
      records_to_lanes<T>(scratch.record, scratch.lanes);
      for (int a = 0; a < 3; ++a) {
        v[a] = V(scratch.lanes[1 + a], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) {
          const V moment(scratch.lanes[4 + 4 * b + 1 + a], stdx::vector_aligned);
          C[a][b] = gradient * (moment + to_center[b] * v[a]);
        }
      }
    } else {
      for (int a = 0; a < 3; ++a) {
        v[a] = V(&v_[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) C[a][b] = V(&C_[3 * a + b][first], stdx::vector_aligned);
      }
    }

    // Controls: enforced velocities of the gathered substep, then those and the forces of the scattered one.
    const bool controlled = group_controlled_[group] != 0;
    const auto enforce = [&](const ControlTable& table, bool changes) {
      alignas(64) T flag[W], numbers[6][W];
      for (int l = 0; l < W; ++l) {
        const int i = particle_[first + l];
        const Control& c = table.group[i >= 0 ? setup_.control_group[i] : 0];
        flag[l] = c.enforce ? T(1) : T(0);
        for (int a = 0; a < 3; ++a) {
          numbers[a][l] = T(c.velocity[a]);
          numbers[3 + a][l] = changes ? T(c.change[a]) : T(0);
        }
      }
      const auto enforced = V(flag, stdx::vector_aligned) > V(T(0));
      const V before = dot(v, v);
      for (int a = 0; a < 3; ++a) {
        const V target(numbers[a], stdx::vector_aligned), change(numbers[3 + a], stdx::vector_aligned);
        v[a] = select(enforced, target, v[a] + change);
        for (int b = 0; b < 3; ++b) C[a][b] = select(enforced, V(T(0)), C[a][b]);
      }
      const V work = T(0.5) * mass * (dot(v, v) - before);
      report.control_work += double(stdx::reduce(at_least(work, V(T(0)))));
      return enforced;
    };

    if (kGather) {
      if (controlled && after_.active) enforce(after_, false);
      const V squared = dot(v, v);
      kinetic += mass * squared;
      speed = at_least(squared, speed);
      finite = finite && (squared - squared == V(T(0)));
      for (int a = 0; a < 3; ++a) x[a] += move * v[a];
      if (at_edge) {
        const Vec3<V> free = x;
        for (int a = 0; a < 3; ++a) x[a] = at_most(at_least(x[a], V(low[a])), V(high[a]));
        const auto held = free.x != x.x || free.y != x.y || free.z != x.z;
        report.clamped += stdx::popcount(held);
      }
      F = F + V(step) * (C * F);
    }
    // A prime pass only evaluates stress; its F has been through the return map already.
    const Mat3<V> tau = update_stress(group, first, p, V(kGather ? step : T(0)), F, strength);
    if (kGather) {
      for (int a = 0; a < 3; ++a) {
        x[a].copy_to(&field_[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) F[a][b].copy_to(&field_[3 + 3 * a + b][first], stdx::vector_aligned);
      }
      if (uses_strength_) strength.copy_to(&strength_[first], stdx::vector_aligned);
    }
    if (!kScatter) {
      for (int a = 0; a < 3; ++a) {
        v[a].copy_to(&v_[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) C[a][b].copy_to(&C_[3 * a + b][first], stdx::vector_aligned);
      }
      continue;
    }

    if (controlled && before_.active) enforce(before_, true);
    locate_group(x);
    // Per cell of offset: m C dx − dt V⁰ (4/dx) τ (MLS-MPM, Hu et al. 2018).
    const V inertia = mass * T(dx_), force = -(step * gradient) * volume;
    const Mat3<V> Q = inertia * C + force * tau;
    const Vec3<V> momentum = mass * v + Q * to_center;
    mass.copy_to(scratch.lanes[0], stdx::vector_aligned);
    for (int a = 0; a < 3; ++a) {
      momentum[a].copy_to(scratch.lanes[1 + a], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) Q[a][b].copy_to(scratch.lanes[4 + 4 * b + 1 + a], stdx::vector_aligned);
    }
    for (int k = 4; k < 16; k += 4) V(T(0)).copy_to(scratch.lanes[k], stdx::vector_aligned);
    lanes_to_records<T>(scratch.lanes, scratch.record);
    for (int l = 0; l < real; ++l) {
      if (scratch.offset[l] != corner) {
        if (corner >= 0) flush_rows(sum, out + corner);
        corner = scratch.offset[l];
      }
      T w[9];
      weights_of(l, w);
      scatter_particle(sum, w, w + 3, w + 6, scratch.record[l]);
    }
  }
  if (kScatter && corner >= 0) flush_rows(sum, out + corner);
  report.kinetic = 0.5 * double(stdx::reduce(kinetic));
  report.max_speed_squared = double(stdx::hmax(speed));
  report.not_finite = !all(finite);
  reports_[index] = report;
}

template <class T>
template <bool kGather, bool kScatter>
void TypedStepper<T>::pass(double dt, StepReport& report) {
  const Stopwatch watch;
  const int count = static_cast<int>(map_.particle_blocks.size());
  setup_.team->for_each(count, [&](int b) { process_block<kGather, kScatter>(b, dt); });
  double kinetic = 0, speed_squared = 0;
  long long clamped = 0;
  for (const BlockReport& r : reports_) {
    kinetic += r.kinetic;
    report.control_work += r.control_work;
    speed_squared = std::max(speed_squared, r.max_speed_squared);
    clamped += r.clamped;
    if (r.not_finite) report.fault = StepFault::not_finite;
  }
  if (kGather) {
    kinetic_ = kinetic;
    report.particles_clamped = std::max(report.particles_clamped, clamped);
    report.max_speed = std::max(report.max_speed, std::sqrt(speed_squared));
    if (report.fault == StepFault::none && std::sqrt(speed_squared) * dt > dx_) report.fault = StepFault::speed;
  }
  report.seconds_particles += watch.seconds();
}

template <class T>
StepReport TypedStepper<T>::advance(int steps, double dt, const ControlSource& controls, double energy_limit) {
  StepReport report;
  if (steps <= 0 || slots_ == 0) return report;
  before_.active = controls(0, before_.group);
  pass<false, true>(dt, report);
  while (true) {
    grid_update(dt, report);
    std::swap(after_, before_);
    if (after_.active) {
      for (const Control& c : after_.group) {
        if (!c.enforce) continue;
        for (int a = 0; a < 3; ++a) next_drift_ = std::max(next_drift_, std::fabs(c.velocity[a]) * dt / dx_);
      }
    }
    if (drift_ > 0 && !(drift_ + next_drift_ <= kDriftLimit)) resort(report);
    const bool last = report.steps + 1 == steps;
    if (last) {
      pass<true, false>(dt, report);
    } else {
      before_.active = controls(report.steps + 1, before_.group);
      pass<true, true>(dt, report);
    }
    drift_ += next_drift_;
    ++report.steps;
    if (report.fault == StepFault::none && kinetic_ > energy_limit + 2 * report.control_work) {
      report.fault = StepFault::energy;
    }
    if (last || report.fault != StepFault::none) return report;
  }
}

}  // namespace

std::unique_ptr<Stepper> make_stepper(Precision precision, const StepperSetup& setup) {
  if (precision == Precision::full) return std::make_unique<TypedStepper<double>>(setup);
  return std::make_unique<TypedStepper<float>>(setup);
}

ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state) {
  using V = Lanes<double>;
  constexpr int W = kLanes<double>;
  constexpr int kChunk = 1024;  // particles per partial sum: fixed, so the total does not depend on the threads
  const int count = static_cast<int>(state.size());
  const int chunks = (count + kChunk - 1) / kChunk;
  std::vector<ElasticSummary> partial(chunks);
  setup.team->for_each(chunks, [&](int chunk) {
    const int end = std::min(count, (chunk + 1) * kChunk);
    ElasticSummary& out = partial[chunk];
    for (int first = chunk * kChunk; first < end; first += W) {
      Mat3<V> F = identity<V>();
      MaterialParameters<V> p{};
      bool present[kBranchCount] = {};
      for (int l = 0; l < W && first + l < end; ++l) {
        const int i = first + l;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) F[a][b][l] = state.F[i][a][b];
        p.mu[l] = setup.parameters[setup.row[i]].mu;
        p.lambda[l] = setup.parameters[setup.row[i]].lambda;
        p.bulk[l] = setup.parameters[setup.row[i]].bulk;
        present[static_cast<int>(setup.branches[setup.row[i]])] = true;
      }
      const V J = determinant(F);
      for (int branch = 0; branch < kBranchCount; ++branch) {
        if (!present[branch]) continue;
        const V energy = branch_energy(static_cast<Branch>(branch), p, F);
        for (int l = 0; l < W && first + l < end; ++l) {
          const int row = setup.row[first + l];
          if (static_cast<int>(setup.branches[row]) != branch) continue;
          out.energy += setup.volume[first + l] * energy[l];
          if (has_potential(static_cast<Branch>(branch))) out.recoverable += setup.volume[first + l] * energy[l];
          out.min_J = std::min(out.min_J, double(J[l]));
          out.max_J = std::max(out.max_J, double(J[l]));
        }
      }
    }
  });
  ElasticSummary total;
  for (const ElasticSummary& p : partial) {
    total.energy += p.energy;
    total.recoverable += p.recoverable;
    total.min_J = std::min(total.min_J, p.min_J);
    total.max_J = std::max(total.max_J, p.max_J);
  }
  return total;
}

}  // namespace physmas::mpm
