// The stepper of a GPU, or of its emulator. The state stays on the device from load to load; the host arranges blocks
// when particles are sorted, and looks at the records of a chunk of substeps at a time.
#ifndef PHYSMAS_MPM_CUDA_GPU_STEPPER_H
#define PHYSMAS_MPM_CUDA_GPU_STEPPER_H

#include <cmath>
#include <cstring>

#include "base/clock.h"
#include "base/team.h"
#include "mpm/cpu/state_summary.h"
#include "mpm/cuda/grid_pass.h"
#include "mpm/cuda/node_pool.h"
#include "mpm/cuda/particle_pass.h"
#include "mpm/stepper.h"

namespace physmas::mpm::PHYSMAS_GPU {

// Substeps that are started before the host looks.
constexpr int kMostInChunk = 32;

template <class T>
class GpuStepper final : public Stepper {
 public:
  // threads: of the CPU, for what it sums up of states.
  GpuStepper(int threads, const StepperSetup& setup);
  long long load(const State& state) override;
  void store(State& state) const override;
  StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) override;
  ElasticSummary summarise_elastic(const State& state) override { return mpm::summarise_elastic(setup_, state, team_); }
  StepBounds measure_bounds(const State& state) override { return mpm::measure_bounds(setup_, state, team_); }
  StepperUsage usage() const override {
    const double blocks = std::pow((setup_.domain.n + kCells) / kCells, 3);
    return {1, static_cast<double>(pool_.block_count()) / blocks, numbers_.bytes() + ints_.bytes() + sorting_bytes(),
            pool_.bytes()};
  }

 private:
  size_t sorting_bytes() const {
    return sorted_numbers_.bytes() + sorted_ints_.bytes() + home_.bytes() + place_.bytes() + key_.bytes() +
           listed_.bytes() + listed_id_.bytes() + listed_key_.bytes() + order_.bytes();
  }
  int count() const { return static_cast<int>(setup_.row.size()); }
  void sort();
  void choose_units(double dt);
  void take_controls(const ControlSource& controls, int first, int steps, int all);
  template <class Kernel>
  void launch(int items, const typename Kernel::Arguments& arguments);
  void start_grid_pass(int step, double dt);
  template <bool kGather, bool kScatter>
  void start_particle_pass(int step, double dt, double energy_limit);

  StepperSetup setup_;
  Team team_;
  mutable Queue queue_;
  Channels channels_;
  NodePool<T> pool_;

  DeviceArray<T> numbers_{queue_}, sorted_numbers_{queue_};
  DeviceArray<int> ints_{queue_}, sorted_ints_{queue_};
  DeviceArray<int> home_{queue_}, place_{queue_}, listed_{queue_}, listed_id_{queue_};
  DeviceArray<unsigned long long> key_{queue_}, listed_key_{queue_}, order_{queue_};
  DeviceArray<int> home_counts_{queue_}, home_starts_{queue_};
  DeviceArray<RowMaterial<T>> rows_{queue_};
  DeviceArray<Collider> colliders_{queue_};
  DeviceArray<T> item_kinetic_{queue_}, item_work_{queue_}, item_velocity_{queue_};
  DeviceArray<int> ticket_{queue_};

  // Controls of the substeps at hand: rows that differ, and which of them a substep has.
  int groups_ = 1;
  std::vector<Control> control_rows_;
  std::vector<unsigned char> uploaded_controls_;
  DeviceArray<Control> controls_{queue_};
  std::vector<StepRecord> records_;
  DeviceArray<StepRecord> device_records_{queue_};

  SumUnits units_;
  int sums_ = 0;      // which array of sums is clean
  double drift_ = 0;  // cells since the last sort, at most
};

template <class T>
GpuStepper<T>::GpuStepper(int threads, const StepperSetup& setup)
    : setup_(setup),
      team_(std::max(1, threads)),
      pool_(queue_, setup_.domain, setup_.contact.bodies()),
      records_(kMostInChunk + 2) {
  for (const int row : setup_.row) {
    if (setup_.branches[row] == Branch::plasticine && channels_.strength < 0) channels_.strength = channels_.count++;
  }
  if (!setup_.elasticity.empty()) channels_.elasticity = channels_.count, channels_.count += 3;
  if (setup_.track_total_F) channels_.total_F = channels_.count, channels_.count += 9;
  const size_t particles = setup_.row.size();
  for (auto* array : {&numbers_, &sorted_numbers_}) array->resize(channels_.count * particles);
  for (auto* array : {&ints_, &sorted_ints_}) array->resize(kIntChannels * particles);
  for (auto* array : {&home_, &place_, &listed_, &listed_id_}) array->resize(particles);
  for (auto* array : {&key_, &listed_key_, &order_}) array->resize(particles);
  for (auto* array : {&home_counts_, &home_starts_}) array->resize(pool_.homes());
  std::vector<RowMaterial<T>> rows;
  for (size_t r = 0; r < setup_.parameters.size(); ++r) {
    rows.push_back({convert_parameters<T>(setup_.parameters[r]), static_cast<int>(setup_.branches[r]),
                    setup_.contact.of(static_cast<int>(r))});
  }
  rows_.upload(rows);
  colliders_.upload(setup_.domain.colliders);
  for (const std::uint16_t group : setup_.control_group) groups_ = std::max(groups_, group + 1);
  ticket_.resize(1);
  ticket_.zero();
  device_records_.resize(records_.size());
  queue_.wait();
}

template <class T>
template <class Kernel>
void GpuStepper<T>::launch(int items, const typename Kernel::Arguments& arguments) {
  static const int fitting = queue_.template fitting_blocks<Kernel>();  // of the one card that is used
  queue_.template launch<Kernel>(std::max(1, std::min(items, fitting)), arguments);
}

template <class T>
long long GpuStepper<T>::load(const State& state) {
  const size_t particles = state.size();
  long long clamped = 0;
  std::vector<T> numbers(channels_.count * particles);
  std::vector<int> ints(kIntChannels * particles);
  const auto put = [&](int channel, size_t i, double value) { numbers[channel * particles + i] = T(value); };
  const double dx = setup_.domain.dx(), low = kEdgeCells, high = setup_.domain.n - kEdgeCells;
  for (size_t i = 0; i < particles; ++i) {
    int block[3];
    bool moved = false;
    for (int a = 0; a < 3; ++a) {
      const double cells = at_most(at_least(state.x[i][a] / dx, low), high);
      moved = moved || cells != state.x[i][a] / dx;
      block[a] = static_cast<int>(std::floor(cells - 0.5)) / kCells;
      put(Channels::kPosition + a, i, cells - kCells * block[a]);
      put(Channels::kVelocity + a, i, state.v[i][a]);
    }
    clamped += moved;
    for (int k = 0; k < 9; ++k) {
      put(Channels::kDeformation + k, i, state.F[i][k / 3][k % 3]);
      put(Channels::kGradient + k, i, state.C[i][k / 3][k % 3]);
      if (channels_.total_F >= 0) put(channels_.total_F + k, i, state.total_F[i][k / 3][k % 3]);
    }
    put(Channels::kVolume, i, setup_.volume[i]);
    if (channels_.strength >= 0) put(channels_.strength, i, state.strength[i]);
    if (channels_.elasticity >= 0) {
      const ParticleElasticity<double>& own = setup_.elasticity[i];
      put(channels_.elasticity, i, own.mu);
      put(channels_.elasticity + 1, i, own.lambda);
      put(channels_.elasticity + 2, i, own.density);
    }
    ints[kId * particles + i] = static_cast<int>(i);
    ints[kRow * particles + i] = setup_.row[i];
    ints[kControl * particles + i] = setup_.control_group[i];
    ints[kBlock * particles + i] = pool_.table.id(block[0], block[1], block[2]);
  }
  numbers_.upload(numbers);
  ints_.upload(ints);
  sort();
  pool_.clear();  // also of what a run left that ended with a fault
  sums_ = 0;
  drift_ = 0;
  queue_.wait();
  return clamped;
}

template <class T>
void GpuStepper<T>::store(State& state) const {
  const size_t particles = setup_.row.size();
  std::vector<T> numbers(channels_.count * particles);
  std::vector<int> ints(kIntChannels * particles);
  queue_.copy_out(numbers.data(), numbers_.data(), numbers.size() * sizeof(T));
  queue_.copy_out(ints.data(), ints_.data(), ints.size() * sizeof(int));
  const double dx = setup_.domain.dx();
  for (size_t p = 0; p < particles; ++p) {
    const auto get = [&](int channel) { return static_cast<double>(numbers[channel * particles + p]); };
    const int i = ints[kId * particles + p];
    int block[3];
    pool_.table.locate(ints[kBlock * particles + p], block);
    for (int a = 0; a < 3; ++a) {
      state.x[i][a] = (get(Channels::kPosition + a) + kCells * block[a]) * dx;
      state.v[i][a] = get(Channels::kVelocity + a);
    }
    for (int k = 0; k < 9; ++k) {
      state.F[i][k / 3][k % 3] = get(Channels::kDeformation + k);
      state.C[i][k / 3][k % 3] = get(Channels::kGradient + k);
      if (channels_.total_F >= 0) state.total_F[i][k / 3][k % 3] = get(channels_.total_F + k);
    }
    if (channels_.strength >= 0) state.strength[i] = get(channels_.strength);
  }
}

template <class T>
void GpuStepper<T>::sort() {
  const size_t particles = setup_.row.size();
  if (particles == 0) return;
  SortArguments<T> a{};
  a.particles = {numbers_.data(), ints_.data(), particles, count()};
  a.sorted = {sorted_numbers_.data(), sorted_ints_.data(), particles, count()};
  a.channels = channels_.count;
  a.table = pool_.table;
  a.rows = rows_.data();
  a.counts = home_counts_.data(), a.starts = home_starts_.data();
  a.home = home_.data(), a.place = place_.data(), a.key = key_.data();
  a.listed = listed_.data(), a.listed_id = listed_id_.data();
  a.listed_key = listed_key_.data(), a.order = order_.data();
  const int items = (count() + PerParticle<T>::kThreads - 1) / PerParticle<T>::kThreads;
  home_counts_.zero();
  launch<FindHomes<T>>(items, a);
  std::vector<int> counts(pool_.homes()), starts;
  queue_.copy_out(counts.data(), home_counts_.data(), counts.size() * sizeof(int));
  pool_.arrange(counts, starts);
  home_starts_.upload(starts);
  launch<ListHomes<T>>(items, a);
  launch<RankInCells<T>>(items, a);
  launch<MoveSorted<T>>(items, a);
  queue_.copy_on(numbers_.data(), sorted_numbers_.data(), numbers_.bytes());
  queue_.copy_on(ints_.data(), sorted_ints_.data(), ints_.bytes());
  item_kinetic_.resize(pool_.item_count());
  item_work_.resize(pool_.item_count());
  item_velocity_.resize(3 * static_cast<size_t>(pool_.item_count()));
  item_velocity_.zero();
  queue_.wait();
}

// No particle may bring more than 2^6 times what the heaviest one has at a cell per substep, and all may meet at a
// node.
template <class T>
void GpuStepper<T>::choose_units(double dt) {
  double heaviest = 0;
  for (size_t i = 0; i < setup_.row.size(); ++i) {
    heaviest = std::max(heaviest, setup_.parameters_of(i).density * setup_.volume[i]);
  }
  const int most = std::ilogb(static_cast<double>(count())) + 1;
  const int mass = std::ilogb(heaviest) + 1, speed = std::ilogb(setup_.domain.dx() / dt) + 1;
  constexpr int kBits = 62, kHeadroom = 6;
  units_.mass = kBits - most - mass;
  units_.momentum = kBits - most - mass - speed - kHeadroom;
  units_.velocity = kFrameBits - speed;
  units_.velocity_units = std::ldexp(1.0, units_.velocity), units_.velocity_of_unit = std::ldexp(1.0, -units_.velocity);
  units_.momentum_units = std::ldexp(1.0, units_.momentum), units_.mass_units = std::ldexp(1.0, units_.mass);
  units_.momentum_of_unit = std::ldexp(1.0, -units_.momentum), units_.mass_of_unit = std::ldexp(1.0, -units_.mass);
  units_.most_momentum = std::ldexp(1.0, mass + speed + kHeadroom);
}

// Of substeps first to first + steps of `all`, into records_ and, where they differ from what is there, onto the
// device.
template <class T>
void GpuStepper<T>::take_controls(const ControlSource& controls, int first, int steps, int all) {
  control_rows_.clear();
  std::vector<Control> row;
  const auto bytes_of = [](const std::vector<Control>& rows, size_t from) {
    // Padding may hold anything: only what is meant is compared.
    std::vector<unsigned char> bytes;
    for (size_t i = from; i < rows.size(); ++i) {
      const Control& c = rows[i];
      const double numbers[] = {c.speed_limit,    c.blend.along,     c.blend.across,
                                c.position.along, c.position.across, c.brake ? 1.0 : 0.0};
      for (const auto& part : {std::make_pair(static_cast<const void*>(&c.velocity), sizeof(c.velocity)),
                               std::make_pair(static_cast<const void*>(&c.gradient), sizeof(c.gradient)),
                               std::make_pair(static_cast<const void*>(&c.center), sizeof(c.center)),
                               std::make_pair(static_cast<const void*>(&c.axis), sizeof(c.axis)),
                               std::make_pair(static_cast<const void*>(&c.change), sizeof(c.change)),
                               std::make_pair(static_cast<const void*>(numbers), sizeof(numbers))}) {
        const auto* const begin = static_cast<const unsigned char*>(part.first);
        bytes.insert(bytes.end(), begin, begin + part.second);
      }
    }
    return bytes;
  };
  for (int k = 0; k <= steps; ++k) {
    StepRecord& record = records_[k];
    record.controls = -1;
    record.enforced = record.raised = 0;
    if (first + k >= all || !controls(first + k, row)) continue;
    row.resize(groups_);
    for (const Control& c : row) {
      if (c.enforces()) record.enforced = std::max(record.enforced, c.top_speed());
      const double weight = std::max(c.position.along, c.position.across);
      if (weight > 0) record.raised = std::max(record.raised, weight * c.speed_limit);
    }
    const size_t last = control_rows_.size();
    control_rows_.insert(control_rows_.end(), row.begin(), row.end());
    if (last > 0 && bytes_of(control_rows_, last) ==
                        bytes_of({control_rows_.begin() + (last - groups_), control_rows_.begin() + last}, 0)) {
      control_rows_.resize(last);
    }
    record.controls = static_cast<int>(control_rows_.size()) / groups_ - 1;
  }
  if (control_rows_.empty()) return;
  std::vector<unsigned char> bytes = bytes_of(control_rows_, 0);
  if (bytes == uploaded_controls_) return;
  controls_.resize(static_cast<size_t>(kMostInChunk + 1) * groups_);
  controls_.upload(control_rows_);
  queue_.wait();
  uploaded_controls_ = std::move(bytes);
}

template <class T>
void GpuStepper<T>::start_grid_pass(int step, double dt) {
  GridPassArguments<T> a{};
  a.blocks = pool_.blocks.data();
  a.block_count = pool_.counts.data() + 1;
  a.slots = pool_.slots.data();
  a.table = pool_.table;
  a.bodies = setup_.contact.bodies();
  a.friction = setup_.contact.friction;
  a.sums[0] = pool_.sums[0].data(), a.sums[1] = pool_.sums[1].data();
  a.velocity = pool_.velocity.data();
  a.units = units_;
  a.colliders = colliders_.data();
  a.collider_count = static_cast<int>(setup_.domain.colliders.size());
  a.records = device_records_.data();
  a.step = step;
  a.ticket = ticket_.data();
  a.gravity = setup_.domain.gravity;
  a.dt = dt, a.dx = setup_.domain.dx();
  a.n = setup_.domain.n, a.wall_cells = setup_.domain.wall_cells;
  if (a.bodies > 1) {
    launch<GridPass<T, true>>(pool_.block_count(), a);
  } else {
    launch<GridPass<T, false>>(pool_.block_count(), a);
  }
}

template <class T>
template <bool kGather, bool kScatter>
void GpuStepper<T>::start_particle_pass(int step, double dt, double energy_limit) {
  ParticlePassArguments<T> a{};
  a.particles = {numbers_.data(), ints_.data(), setup_.row.size(), count()};
  a.channels = channels_;
  a.items = pool_.items.data();
  a.item_count = pool_.counts.data();
  a.slots = pool_.slots.data();
  a.table = pool_.table;
  a.velocity = pool_.velocity.data();
  a.sums[0] = pool_.sums[0].data(), a.sums[1] = pool_.sums[1].data();
  a.units = units_;
  a.rows = rows_.data();
  a.controls = controls_.data();
  a.groups = groups_;
  a.records = device_records_.data();
  a.step = step;
  a.ticket = ticket_.data();
  a.item_kinetic = item_kinetic_.data(), a.item_work = item_work_.data();
  a.item_velocity = item_velocity_.data();
  a.dt = dt, a.dx = setup_.domain.dx(), a.energy_limit = energy_limit;
  a.n = setup_.domain.n;
  launch<ParticlePass<T, kGather, kScatter>>(pool_.item_count(), a);
}

template <class T>
StepReport GpuStepper<T>::advance(int steps, double dt, const ControlSource& controls, double energy_limit) {
  StepReport report;
  if (steps <= 0 || count() == 0) return report;
  const Stopwatch watch;
  choose_units(dt);
  const StepFault faults[] = {StepFault::none, StepFault::not_finite, StepFault::speed, StepFault::energy};
  double drift = drift_, next_drift = 0, work = 0;
  bool begun = false, sorted = false;
  while (true) {
    // As many substeps as are expected before the next sort.
    const int left = steps - report.steps;
    const double expected = next_drift > 0 ? (kDriftLimit - drift) / next_drift + 1 : kMostInChunk;
    const int chunk = static_cast<int>(std::max(1.0, std::min({expected, double(kMostInChunk), double(left)})));
    take_controls(controls, report.steps, chunk, steps);
    for (int k = 0; k <= chunk; ++k) {
      StepRecord& record = records_[k];
      const StepRecord given = record;
      record = {};
      record.controls = given.controls, record.enforced = given.enforced, record.raised = given.raised;
      record.sums = (sums_ + k) % 2;
    }
    StepRecord& first = records_[0];
    first.drift = drift, first.work = work;
    first.grid_due = sorted ? 0 : 1;
    if (sorted) first.particles_due = 1, first.next_drift = next_drift;
    queue_.copy_in(device_records_.data(), records_.data(), (chunk + 1) * sizeof(StepRecord));
    if (!begun) start_particle_pass<false, true>(0, dt, energy_limit);
    begun = true;
    for (int k = 0; k < chunk; ++k) {
      if (k > 0 || !sorted) start_grid_pass(k, dt);
      if (report.steps + k + 1 == steps) {
        start_particle_pass<true, false>(k, dt, energy_limit);
      } else {
        start_particle_pass<true, true>(k, dt, energy_limit);
      }
    }
    queue_.copy_out(records_.data(), device_records_.data(), (chunk + 1) * sizeof(StepRecord));
    sorted = false;
    int k = 0;
    for (; k < chunk && records_[k].done != 0 && report.fault == StepFault::none; ++k) {
      const StepRecord& record = records_[k];
      ++report.steps;
      double squared;
      std::memcpy(&squared, &record.particle_speed, sizeof(squared));
      report.max_speed = std::max(report.max_speed, std::sqrt(squared));
      report.particles_clamped = std::max<long long>(report.particles_clamped, record.clamped);
      report.fault = faults[record.fault];
      next_drift = record.next_drift;
      drift = record.drift + record.next_drift;
      work = records_[k + 1].work;
    }
    sums_ = (sums_ + k) % 2;
    drift_ = drift;
    report.control_work = work;
    if (report.fault != StepFault::none || report.steps == steps) break;
    if (k == chunk) continue;
    // The grid has been updated, but particles could drift too far.
    if (records_[k].grid_due == 0) throw internal_error("a substep on the GPU was not done");
    next_drift = records_[k].next_drift;
    const Stopwatch sorting;
    sort();
    report.seconds_sort += sorting.seconds();
    ++report.sorts;
    sorted = true;
    drift = drift_ = 0;
  }
  queue_.wait();
  report.seconds_particles = watch.seconds() - report.seconds_sort;
  return report;
}

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
