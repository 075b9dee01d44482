#include "base/team.h"

#include <algorithm>
#include <system_error>

#include "base/machine_limits.h"

namespace physmas {

namespace {

// Rounds of waiting: first busy, some 10 µs in all, then offering the core to others.
constexpr int kBusyRounds = 1000;
constexpr int kYieldRounds = 50;

}  // namespace

void Team::pause(int round) {
  if (round >= kBusyRounds) {
    std::this_thread::yield();
    return;
  }
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

Team::Team(int threads) : ranges_(std::max(1, threads)) {
  try {
    workers_.reserve(ranges_.size());
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this, i] { serve(i); });
  } catch (const std::system_error&) {
    end();
    throw no_thread();
  } catch (...) {
    end();
    throw;
  }
}

Team::~Team() {
  end();
}

void Team::end() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

std::vector<int> Team::even_ranges(int count, int ranges) {
  std::vector<int> bounds(ranges + 1);
  for (int t = 0; t <= ranges; ++t) bounds[t] = static_cast<int>(static_cast<long long>(count) * t / ranges);
  return bounds;
}

bool Team::take_one(int thread) {
  // Only in the job that is announced: a call may wait for one that only the thread of another range will make, which
  // must not be caught in a later call of this range because it found its own one still closed or of the job before.
  const std::uint64_t job = announced_.load();
  for (size_t k = 0; k < ranges_.size(); ++k) {
    Range& range = ranges_[(thread + k) % ranges_.size()];
    std::uint64_t ticket = range.ticket.load();
    const auto index = static_cast<std::uint32_t>(ticket);
    const int end = range.end.load();
    const Call call = call_.load();
    const void* context = context_.load();
    if (ticket >> 32 != job) return false;
    if (index >= static_cast<std::uint32_t>(end)) continue;
    // Success means that no other job was opened since the ticket was read, so the fields above belong to it.
    if (range.ticket.compare_exchange_strong(ticket, ticket + 1)) {
      call(context, static_cast<int>(index));
      done_.fetch_add(1);
    }
    return true;
  }
  return false;
}

void Team::share(const std::vector<int>& bounds, Call call, const void* context) {
  const std::uint64_t job = ++job_ << 32;
  // Nobody can claim while the fields change.
  for (Range& range : ranges_) range.ticket.store(job | kClosed);
  done_.store(0);
  call_.store(call);
  context_.store(context);
  for (size_t t = 0; t < ranges_.size(); ++t) ranges_[t].end.store(bounds[t + 1]);
  for (size_t t = 0; t < ranges_.size(); ++t) ranges_[t].ticket.store(job | static_cast<std::uint32_t>(bounds[t]));
  announced_.store(job_);
  if (sleeping_.load() > 0) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wake_.notify_all();
  }
  while (take_one(0)) {
  }
  for (int round = 0; done_.load() < bounds.back(); ++round) pause(round);
}

void Team::serve(int thread) {
  int round = 0;
  while (!ending_.load()) {
    const std::uint64_t seen = announced_.load();
    if (take_one(thread)) {
      round = 0;
      continue;
    }
    if (++round < kBusyRounds + kYieldRounds) {
      pause(round);
      continue;
    }
    std::unique_lock<std::mutex> lock(mutex_);
    sleeping_.fetch_add(1);
    // A job announced before the count of sleepers rose wakes nobody: the condition is checked before the first wait.
    wake_.wait(lock, [&] { return ending_.load() || announced_.load() != seen; });
    sleeping_.fetch_sub(1);
    round = 0;
  }
}

}  // namespace physmas
