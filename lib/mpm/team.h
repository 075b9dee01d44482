// A few threads that share loops of a few microseconds. OpenMP's barriers spin for milliseconds, which is ruinous when
// several programs share the cores (`make -j`); these threads spin for some microseconds, then give way, then sleep.
#ifndef PHYSMAS_MPM_TEAM_H
#define PHYSMAS_MPM_TEAM_H

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace physmas::mpm {

class Team {
 public:
  // threads: the calling thread included, at least 1.
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls work(i) once for every i in 0..count-1, on any thread and in any order, and returns when all calls have.
  // Called by one thread at a time; `work` must not throw.
  template <class Work>
  void for_each(int count, const Work& work) {
    if (workers_.empty() || count <= 1) {
      for (int i = 0; i < count; ++i) work(i);
      return;
    }
    share(
        count, [](const void* context, int i) { (*static_cast<const Work*>(context))(i); }, &work);
  }

 private:
  using Call = void (*)(const void* context, int i);
  void share(int count, Call call, const void* context);
  bool take_one();
  void serve();

  // (job number << 32) | next index. An index is claimed by a compare-and-swap on the whole word, so that a thread that
  // comes late can never take part in another job than the one whose fields it has read.
  std::atomic<std::uint64_t> ticket_{kClosed};
  std::atomic<int> count_{0}, done_{0};
  std::atomic<Call> call_{nullptr};
  std::atomic<const void*> context_{nullptr};

  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<int> sleeping_{0};
  std::atomic<bool> ending_{false};
  std::vector<std::thread> workers_;

  static constexpr std::uint64_t kClosed = 0xffffffff;
};

}  // namespace physmas::mpm

#endif
