// A few threads that share loops of a few microseconds. OpenMP's barriers spin for milliseconds, which is ruinous when
// several programs share the cores (`make -j`); these threads spin for some microseconds, then give way, then sleep.
#ifndef PHYSMAS_BASE_TEAM_H
#define PHYSMAS_BASE_TEAM_H

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace physmas {

class Team {
 public:
  // threads: the calling thread included, at least 1. An Error (exit code 3) where the machine does not give them.
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls work(i) once for every i in 0..count-1, on any thread, and returns when all calls have. Called by one thread
  // at a time; `work` must not throw. Every thread begins with a range of its own, the same for the same count, so that
  // what it touched is still in its cache when neighbouring i mean neighbouring memory.
  template <class Work>
  void for_each(int count, const Work& work) {
    for_each(even_ranges(count, threads()), work);
  }
  // The same with the threads' ranges given: bounds[t] to bounds[t + 1] - 1, threads() of them. Every range is worked
  // off in ascending order, and by its own thread unless another one has run out of work; a first range that has
  // everything is left to the calling thread.
  template <class Work>
  void for_each(const std::vector<int>& bounds, const Work& work) {
    if (workers_.empty() || bounds.back() <= 1 || bounds[1] == bounds.back()) {
      for (int i = 0; i < bounds.back(); ++i) work(i);
      return;
    }
    share(
        bounds, [](const void* context, int i) { (*static_cast<const Work*>(context))(i); }, &work);
  }
  static std::vector<int> even_ranges(int count, int ranges);

  // One round, counted from 0, of waiting for another thread.
  static void pause(int round);

 private:
  using Call = void (*)(const void* context, int i);
  void share(const std::vector<int>& bounds, Call call, const void* context);
  bool take_one(int thread);
  void serve(int thread);
  void end();

  // One per range: (job number << 32) | next index. An index is claimed by a compare-and-swap on the whole word, so
  // that a thread that comes late can never take part in another job than the one whose fields it has read.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> ticket{kClosed};
    std::atomic<int> end{0};
  };
  std::vector<Range> ranges_;
  std::uint64_t job_ = 0;  // of the calling thread
  std::atomic<std::uint64_t> announced_{0};
  std::atomic<int> done_{0};
  std::atomic<Call> call_{nullptr};
  std::atomic<const void*> context_{nullptr};

  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<int> sleeping_{0};
  std::atomic<bool> ending_{false};
  std::vector<std::thread> workers_;

  static constexpr std::uint64_t kClosed = 0xffffffff;
};

}  // namespace physmas

#endif
