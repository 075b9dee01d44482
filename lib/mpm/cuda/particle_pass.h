// What one substep does with the particles: gather from the grid, move, deform, evaluate stress, scatter. Where one
// substep follows another, its last three phases and the first one of the next are one pass over the particles, as on
// the CPU (cpu/block_pass.h).
#ifndef PHYSMAS_MPM_CUDA_PARTICLE_PASS_H
#define PHYSMAS_MPM_CUDA_PARTICLE_PASS_H

#include "mpm/action/control_motion.h"
#include "mpm/cuda/tile.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm::PHYSMAS_GPU {

// A strength [Pa] that no stress reaches; fits every type.
constexpr double kNeverYields = 1e30;

template <class T>
struct ParticlePassArguments {
  ParticleArrays<T> particles;
  Channels channels;
  const Item* items;
  const int* item_count;
  const int* slots;  // [bodies][table.count()], -1: none
  BlockTable table;
  const NodeVelocity<T>* velocity;
  NodeSum* sums[2];
  SumUnits units;
  const RowMaterial<T>* rows;
  const Control* controls;  // [rows of the table of controls][groups]
  int groups;
  StepRecord* records;  // of the chunk
  int step;             // which of them
  int* ticket;
  T* item_kinetic;  // per item
  T* item_work;
  T* item_velocity;  // [3] of the first particle in the last substep [m/s]; 0 after a sort
  double dt, dx, energy_limit;
  int n;
};

// kGather: ends a substep of dt; kScatter: begins one.
template <class T, bool kGather, bool kScatter>
class ParticlePass {
 public:
  using Arguments = ParticlePassArguments<T>;
  // Sums of float are ints in shared memory, scaled for the item; those of double go to the grid one by one.
  static constexpr bool kTileSums = sizeof(T) == 4;
  static constexpr int kThreads = kTileSums ? kMostInItem : 128;
  static constexpr int kResident = kTileSums ? 2 : 1;
  static constexpr int kPhases = 6, kFinalPhases = 3;
  static constexpr int kParts = 16;  // of sums over threads
  using Bits = decltype(bits_of(T()));

  struct Shared {
    NodeVelocity<T> velocity[kGather ? kVelocityTile : 1];
    int sums[kScatter && kTileSums ? 4 * kSumTile : 1];
    int slot[kNeighbours];
    int frame[3];       // a velocity
    unsigned bound[2];  // largest momentum and mass of a gift, as bits
    Bits speed;         // largest square, as bits
    int clamped, not_finite;
    int unbearable;  // kinds of momenta that the grid cannot bear
    T kinetic[kThreads], work[kThreads];
    double total_kinetic[kThreads], total_work[kThreads];
  };

  PHYSMAS_DEVICE ParticlePass(const Arguments& arguments, Shared& shared, int thread)
      : a_(arguments), s_(shared), thread_(thread) {}

  PHYSMAS_DEVICE int items() const { return kGather && a_.records[a_.step].particles_due == 0 ? 0 : *a_.item_count; }
  PHYSMAS_DEVICE int* ticket() const { return a_.ticket; }

  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    if constexpr (kPhase == 0) begin(item);
    if constexpr (kPhase == 1 && kGather) load_tile(item);
    if constexpr (kPhase == 2) advance(item);
    if constexpr (kPhase == 3 && kScatter) bound_gift();
    if constexpr (kPhase == 3) add_parts();
    if constexpr (kPhase == 4 && kScatter) scatter_gift();
    if constexpr (kPhase == kPhases - 1) finish(item);
  }

  template <int kPhase>
  PHYSMAS_DEVICE void final_phase() {
    if (kGather && a_.records[a_.step].particles_due == 0) return;
    if constexpr (kPhase == 0) {
      // Every thread its share of the items, in order.
      const int count = *a_.item_count;
      double kinetic = 0, work = 0;
      for (int i = thread_; i < count; i += kThreads) {
        kinetic += static_cast<double>(fresh(a_.item_kinetic + i));
        work += static_cast<double>(fresh(a_.item_work + i));
      }
      s_.total_kinetic[thread_] = kinetic;
      s_.total_work[thread_] = work;
    }
    if constexpr (kPhase == 1) {
      if (thread_ >= kParts) return;
      double kinetic = 0, work = 0;
      for (int t = thread_; t < kThreads; t += kParts) kinetic += s_.total_kinetic[t], work += s_.total_work[t];
      // Nobody else reads these.
      s_.total_kinetic[thread_] = kinetic;
      s_.total_work[thread_] = work;
    }
    if constexpr (kPhase == 2) {
      if (thread_ == 0) judge();
    }
  }

 private:
  PHYSMAS_DEVICE T number(int channel) const { return a_.particles.channel(channel)[particle_]; }
  PHYSMAS_DEVICE void put(int channel, const T& value) const { a_.particles.channel(channel)[particle_] = value; }

  PHYSMAS_DEVICE void begin(int item) {
    const Item home = a_.items[item];
    if (thread_ < kNeighbours) {
      s_.slot[thread_] = a_.slots[home.body * a_.table.count() + a_.table.neighbour(home.block, thread_)];
    }
    if constexpr (kScatter && kTileSums) {
      for (int i = thread_; i < 4 * kSumTile; i += kThreads) s_.sums[i] = 0;
    }
    if (thread_ == 0) {
      s_.bound[0] = s_.bound[1] = 0;
      s_.speed = 0;
      s_.clamped = s_.not_finite = s_.unbearable = 0;
    }
    here_ = thread_ < home.count;
    particle_ = home.first + thread_;
    if (!here_) return;
    for (int k = 0; k < 3; ++k) x_[k] = number(Channels::kPosition + k);
    for (int k = 0; k < 9; ++k) F_[k / 3][k % 3] = number(Channels::kDeformation + k);
  }

  // Where node i of the tile lies in the pool of nodes.
  PHYSMAS_DEVICE size_t node_of(int x, int y, int z) const {
    const int neighbour = ((x + 3) / kCells * 3 + (y + 3) / kCells) * 3 + (z + 3) / kCells;
    const int inside = ((x + 3) % kCells * kCells + (y + 3) % kCells) * kCells + (z + 3) % kCells;
    return static_cast<size_t>(s_.slot[neighbour]) * kBlockNodes + inside;
  }

  // Relative to how the item's first particle moved in the last substep: what a body that flies has in common would
  // cost the digits that its deformation needs.
  PHYSMAS_DEVICE void load_tile(int item) {
    for (int k = 0; k < 3; ++k) common_[k] = a_.item_velocity[3 * item + k];
    for (int i = thread_; i < kTileNodes; i += kThreads) {
      const int x = i / (kTile * kTile), y = i / kTile % kTile, z = i % kTile;
      NodeVelocity<T> node = a_.velocity[node_of(x, y, z)];
      for (int k = 0; k < 3; ++k) node.u[k] -= common_[k];
      s_.velocity[x * kVelocityX + y * kVelocityY + z] = node;
    }
  }

  PHYSMAS_DEVICE LocalControl<T> control_of(const Item& home, int table_row) const {
    const Vec3d origin = {kCells * home.position[0] * a_.dx, kCells * home.position[1] * a_.dx,
                          kCells * home.position[2] * a_.dx};
    return localise<T>(a_.controls[static_cast<size_t>(table_row) * a_.groups + group_], origin, a_.dx);
  }

  PHYSMAS_DEVICE void advance(int item) {
    T kinetic(0), work(0);
    largest_squared_ = T(0);
    if (here_) advance_particle(item, kinetic, work);
    if constexpr (kGather) raise_together(&s_.speed, bits_of(largest_squared_));
    s_.kinetic[thread_] = kinetic;
    s_.work[thread_] = work;
  }

  PHYSMAS_DEVICE void advance_particle(int item, T& kinetic, T& work) {
    const Item& home = a_.items[item];
    const RowMaterial<T>& row = a_.rows[a_.particles.channel_of_ints(kRow)[particle_]];
    const Branch branch = static_cast<Branch>(row.branch);
    MaterialParameters<T> p = row.parameters;
    if (a_.channels.elasticity >= 0) {
      const int c = a_.channels.elasticity;
      p = with_elasticity(p, ParticleElasticity<T>{number(c), number(c + 1), number(c + 2)});
    }
    const bool softens = branch == Branch::plasticine && a_.channels.strength >= 0;
    const T volume = number(Channels::kVolume), mass = p.density * volume;
    // Without a step the stress alone is asked for. F has been through the return map already: where that has softened
    // Plasticine, it would yield a second time.
    T strength = kGather ? (softens ? number(a_.channels.strength) : T(1)) : T(kNeverYields);
    const T step = T(a_.dt), gradient = T(4 / a_.dx);
    Vec3<T> v;
    Mat3<T> C;
    if constexpr (kGather) {
      gather(s_.velocity, stencil_of(x_), v, C);
      v = v + common_;
      C = gradient * C;
    } else {
      for (int k = 0; k < 3; ++k) v[k] = number(Channels::kVelocity + k);
      for (int k = 0; k < 9; ++k) C[k / 3][k % 3] = number(Channels::kGradient + k);
    }

    // Controls: the forced motion of the gathered substep, then blends and forces of the scattered one.
    const int after = kGather ? a_.records[a_.step].controls : -1;
    const int before = kScatter ? a_.records[a_.step + (kGather ? 1 : 0)].controls : -1;
    group_ = after >= 0 || before >= 0 ? a_.particles.channel_of_ints(kControl)[particle_] : 0;
    const bool forced = group_ != 0 && after >= 0;
    ForcedMotion<T> motion;
    if constexpr (kGather) {
      Mat3<T> deforming = C;
      if (forced) {
        motion = enforce_motion(control_of(home, after), x_, mass, v, C);
        work += motion.gain;
        deforming = C + motion.increment_gradient;
      }
      kinetic = mass * dot(v, v);
      move(home, forced, motion, kinetic, v);
      F_ = F_ + step * (deforming * F_);
      if (a_.channels.total_F >= 0) {
        Mat3<T> total;
        for (int k = 0; k < 9; ++k) total[k / 3][k % 3] = number(a_.channels.total_F + k);
        total = total + step * (deforming * total);
        for (int k = 0; k < 9; ++k) put(a_.channels.total_F + k, total[k / 3][k % 3]);
      }
    }
    const Mat3<T> tau = update_branch(branch, p, kGather ? step : T(0), F_, strength);
    if (forced) work += elastic_gain(motion, tau, volume, step);
    if constexpr (kGather) {
      for (int k = 0; k < 3; ++k) put(Channels::kPosition + k, x_[k]);
      for (int k = 0; k < 9; ++k) put(Channels::kDeformation + k, F_[k / 3][k % 3]);
      if (softens) put(a_.channels.strength, strength);
    }
    if constexpr (!kScatter) {
      for (int k = 0; k < 3; ++k) put(Channels::kVelocity + k, v[k]);
      for (int k = 0; k < 9; ++k) put(Channels::kGradient + k, C[k / 3][k % 3]);
    } else {
      if (group_ != 0 && before >= 0) work += blend_motion(control_of(home, before), x_, mass, v, C);
      // MLS forces (Hu et al. 2018), per cell of offset: m C dx − dt V⁰ (4/dx) τ.
      gift_.momentum = v;  // times mass in bound_gift
      gift_.slope = (mass * T(a_.dx)) * C + (-(step * gradient) * volume) * tau;
      gift_.mass = mass;
      if (thread_ == 0) {
        for (int k = 0; k < 3; ++k) {
          a_.item_velocity[3 * item + k] = v[k];
          if constexpr (kTileSums) s_.frame[k] = frame_of(v[k]);
        }
      }
    }
  }

  // Moves by a substep; forced: with `motion` on top of what was gathered.
  PHYSMAS_DEVICE void move(const Item& home, bool forced, const ForcedMotion<T>& motion, const T& kinetic,
                           const Vec3<T>& v) {
    const T cells = T(a_.dt / a_.dx);
    Vec3<T> whole = v;
    T squared = dot(v, v);
    for (int k = 0; k < 3; ++k) x_[k] += cells * v[k];
    if (forced) {
      for (int k = 0; k < 3; ++k) x_[k] += cells * motion.increment[k];
      whole = v + motion.increment;
      squared = at_least(dot(whole, whole), squared);
    }
    const Vec3<T> moved = x_;
    for (int k = 0; k < 3; ++k) {
      const T low = T(kEdgeCells - kCells * home.position[k]), high = T(a_.n - kEdgeCells - kCells * home.position[k]);
      x_[k] = at_most(at_least(x_[k], low), high);
    }
    if (moved.x != x_.x || moved.y != x_.y || moved.z != x_.z) add(&s_.clamped, 1);
    const bool finite = kinetic - kinetic == T(0);
    if (finite) largest_squared_ = squared;
    if (!finite) set_bits(&s_.not_finite, 1);
    // Of a run that ends here, these are the ones to be looked at.
    if (!finite || !(squared * cells * cells <= T(1))) {
      for (int k = 0; k < 3; ++k) put(Channels::kVelocity + k, whole[k]);
    }
  }

  // A velocity in whole units that are fine enough for what frames are for (bound_gift).
  PHYSMAS_DEVICE int frame_of(const T& v) const {
    constexpr float kMost = 1 << kFrameBits;
    return nearest_int(at_most(at_least(static_cast<float>(v * T(a_.units.velocity_units)), -kMost), kMost));
  }

  // Sums in shared memory are of momenta relative to the velocity of the item's first particle, its frame: a body that
  // flies does not lose the digits that its deformation needs. finish() adds frame × mass, and as it takes the sums of
  // mass that the nodes' velocities are divided by, their rounding makes no difference.
  PHYSMAS_DEVICE void bound_gift() {
    T bound(0);
    if (here_) {
      for (int k = 0; k < 3; ++k) {
        const Vec3<T>& q = gift_.slope[k];
        const T spin = T(1.5) * (absolute(q.x) + absolute(q.y) + absolute(q.z));
        const T size = absolute(gift_.mass * gift_.momentum[k]) + spin;
        if (size <= T(a_.units.most_momentum)) {
          if constexpr (kTileSums) {
            gift_.momentum[k] -= T(s_.frame[k]) * T(a_.units.velocity_of_unit);
            bound = at_least(absolute(gift_.mass * gift_.momentum[k]) + spin, bound);
          }
          continue;
        }
        // A whole number cannot carry it on to the particles around.
        const bool finite = size - size == T(0);
        set_bits(&s_.unbearable, finite ? kOverflow : kInfinite);
        if (!finite) put(Channels::kVelocity + k, size);
      }
    }
    gift_.momentum = gift_.mass * gift_.momentum;
    if constexpr (kTileSums) {
      raise_together(&s_.bound[0], bits_of(bound));
      raise_together(&s_.bound[1], bits_of(here_ ? gift_.mass : T(0)));
    }
  }

  PHYSMAS_DEVICE void scatter_gift() {
    if constexpr (kScatter) {
      if (!here_) return;
      const Stencil<T> s = stencil_of(x_);
      const int bx = s.base[0] + 1, by = s.base[1] + 1, bz = s.base[2] + 1;
      if constexpr (kTileSums) {
        // The gift is scaled instead of every number.
        const T momentum_scale = int_scale(s_.bound[0]).scale, mass_scale = int_scale(s_.bound[1]).scale;
        const Gift<T> scaled = {momentum_scale * gift_.momentum, momentum_scale * gift_.slope, mass_scale * gift_.mass};
        int* const first = s_.sums + bx * kSumX + by * kSumY + bz;
        scatter(s, scaled, [&](int i, int j, int k, const T* momentum, T mass) {
          int* const to = first + i * kSumX + j * kSumY + k;
          add(to, nearest_int(momentum[0]));
          add(to + kSumTile, nearest_int(momentum[1]));
          add(to + 2 * kSumTile, nearest_int(momentum[2]));
          add(to + 3 * kSumTile, nearest_int(mass));
        });
      } else {
        NodeSum* const sums = target();
        scatter(s, gift_, [&](int i, int j, int k, const T* momentum, T mass) {
          NodeSum* const to = sums + node_of(bx + i, by + j, bz + k);
          for (int c = 0; c < 3; ++c) add_global(&to->momentum[c], nearest_long(momentum[c] * a_.units.momentum_units));
          add_global(&to->mass, nearest_long(mass * a_.units.mass_units));
        });
      }
    }
  }

  // The array that the next substep's sums go to.
  PHYSMAS_DEVICE NodeSum* target() const {
    const int of_step = a_.records[a_.step].sums;
    return a_.sums[kGather ? 1 - of_step : of_step];
  }

  // Sums over threads are always taken in the same order.
  PHYSMAS_DEVICE void add_parts() {
    if (thread_ >= kParts) return;
    double kinetic = 0, work = 0;
    for (int t = thread_; t < kThreads; t += kParts) {
      kinetic += static_cast<double>(s_.kinetic[t]);
      work += static_cast<double>(s_.work[t]);
    }
    s_.total_kinetic[thread_] = kinetic;
    s_.total_work[thread_] = work;
  }

  PHYSMAS_DEVICE void finish(int item) {
    if constexpr (kScatter && kTileSums) {
      const int momentum_shift = a_.units.momentum - int_scale(s_.bound[0]).exponent;
      const int mass_shift = a_.units.mass - int_scale(s_.bound[1]).exponent;
      const int frame_shift = a_.units.momentum - a_.units.velocity - int_scale(s_.bound[1]).exponent;
      NodeSum* const sums = target();
      for (int i = thread_; i < kTileNodes; i += kThreads) {
        const int x = i / (kTile * kTile), y = i / kTile % kTile, z = i % kTile;
        const int* const from = s_.sums + x * kSumX + y * kSumY + z;
        if (from[3 * kSumTile] == 0) continue;
        NodeSum* const to = sums + node_of(x, y, z);
        for (int c = 0; c < 3; ++c) {
          const long long of_frame = static_cast<long long>(from[3 * kSumTile]) * s_.frame[c];
          add_global(&to->momentum[c], shifted(from[c * kSumTile], momentum_shift) + shifted(of_frame, frame_shift));
        }
        add_global(&to->mass, shifted(from[3 * kSumTile], mass_shift));
      }
    }
    if (thread_ != 0) return;
    double kinetic = 0, work = 0;
    for (int t = 0; t < kParts; ++t) kinetic += s_.total_kinetic[t], work += s_.total_work[t];
    a_.item_kinetic[item] = T(kinetic);
    a_.item_work[item] = T(work);
    StepRecord& record = a_.records[a_.step];
    raise(&record.particle_speed, bits_of(static_cast<double>(number_of(s_.speed))));
    if (s_.clamped != 0) add(&record.clamped, s_.clamped);
    if (s_.not_finite != 0) set_bits(&record.not_finite, 1);
    // It shows in the particles at the end of the substep that begins.
    if (kScatter && s_.unbearable != 0) set_bits(&a_.records[a_.step + (kGather ? 1 : 0)].unbearable, s_.unbearable);
  }

  // Whether the run may go on.
  PHYSMAS_DEVICE void judge() {
    StepRecord& record = a_.records[a_.step];
    double kinetic = 0, work = 0;
    for (int t = 0; t < kParts; ++t) kinetic += s_.total_kinetic[t], work += s_.total_work[t];
    work += record.work;
    if constexpr (!kGather) {
      record.work = work;
    } else {
      record.kinetic = 0.5 * kinetic;
      const double speed = std::sqrt(number_of(fresh(&record.particle_speed)));
      const int unbearable = fresh(&record.unbearable);
      int fault = kNoFault;
      if (fresh(&record.not_finite) != 0 || (unbearable & kInfinite) != 0) {
        fault = kNotFinite;
      } else if (speed * a_.dt > a_.dx || unbearable != 0) {
        fault = kTooFast;
      } else if (record.kinetic > a_.energy_limit + 2 * work) {
        fault = kTooMuchEnergy;
      }
      record.fault = fault;
      record.done = 1;
      StepRecord& next = a_.records[a_.step + 1];
      next.work = work;
      next.drift = record.drift + record.next_drift;
      next.grid_due = fault == kNoFault ? 1 : 0;
    }
  }

  const Arguments& a_;
  Shared& s_;
  const int thread_;
  bool here_ = false;  // whether this thread has a particle
  int particle_ = 0, group_ = 0;
  Vec3<T> x_, common_;
  Mat3<T> F_;
  Gift<T> gift_;
  T largest_squared_;  // speed [m/s], squared
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
