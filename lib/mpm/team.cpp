#include "mpm/team.h"

namespace physmas::mpm {

namespace {

// Rounds of waiting: first busy, some 10 µs in all, then offering the core to others.
constexpr int kBusyRounds = 1000;
constexpr int kYieldRounds = 50;

void pause(int round) {
  if (round >= kBusyRounds) {
    std::this_thread::yield();
    return;
  }
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

Team::Team(int threads) {
  for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { serve(); });
}

Team::~Team() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

bool Team::take_one() {
  std::uint64_t ticket = ticket_.load();
  const auto index = static_cast<std::uint32_t>(ticket);
  const int count = count_.load();
  const Call call = call_.load();
  const void* context = context_.load();
  if (index >= static_cast<std::uint32_t>(count)) return false;
  // Success means that no other job was opened since the ticket was read, so the fields above belong to it.
  if (ticket_.compare_exchange_strong(ticket, ticket + 1)) {
    call(context, static_cast<int>(index));
    done_.fetch_add(1);
  }
  return true;
}

void Team::share(int count, Call call, const void* context) {
  const std::uint64_t job = ((ticket_.load() >> 32) + 1) << 32;
  ticket_.store(job | kClosed);  // nobody can claim while the fields change
  count_.store(count);
  done_.store(0);
  call_.store(call);
  context_.store(context);
  ticket_.store(job);
  if (sleeping_.load() > 0) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wake_.notify_all();
  }
  while (take_one()) {
  }
  for (int round = 0; done_.load() < count; ++round) pause(round);
}

void Team::serve() {
  int round = 0;
  while (!ending_.load()) {
    if (take_one()) {
      round = 0;
      continue;
    }
    if (++round < kBusyRounds + kYieldRounds) {
      pause(round);
      continue;
    }
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint64_t job = ticket_.load() >> 32;
    sleeping_.fetch_add(1);
    // A job opened before the count of sleepers rose is not announced: the condition is checked before the first wait.
    // One that is over by the time this thread wakes ends the sleep as well: where there was one job, the next is near.
    wake_.wait(lock, [&] {
      const std::uint64_t ticket = ticket_.load();
      return ending_.load() || ticket >> 32 != job ||
             static_cast<std::uint32_t>(ticket) < static_cast<std::uint32_t>(count_.load());
    });
    sleeping_.fetch_sub(1);
    round = 0;
  }
}

}  // namespace physmas::mpm
