// Work that may end its process, by a signal or without an end, done in a process of its own.
#ifndef PHYSMAS_BASE_APART_H
#define PHYSMAS_BASE_APART_H

#include <functional>
#include <string>

namespace physmas {

// How work in a process of its own ended.
struct Ending {
  bool done = false;      // it returned
  int signal = 0;         // it was ended by this one
  bool too_long = false;  // it took more than its seconds
};

// Calls `work` in a copy of this process, which sees all that this one holds and changes nothing of it; an Error that
// it throws is thrown here. seconds: of processor time, at least 1. Where no process can be started, `work` is called
// here.
Ending run_apart(const std::function<void()>& work, int seconds);

}  // namespace physmas

#endif
