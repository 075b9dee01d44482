// What other libraries print to standard error by themselves: libpng and libjpeg do, about files that they read all the
// same.
#ifndef PHYSMAS_BASE_FOREIGN_LINES_H
#define PHYSMAS_BASE_FOREIGN_LINES_H

#include <mutex>
#include <string>

namespace physmas {

// While it lives, what is printed to standard error is kept. One at a time; others wait.
class ForeignLines {
 public:
  ForeignLines();
  ~ForeignLines();
  ForeignLines(const ForeignLines&) = delete;
  ForeignLines& operator=(const ForeignLines&) = delete;
  // Prints as before again; what was kept, at most 4096 bytes of it.
  std::string take();

 private:
  std::unique_lock<std::mutex> lock_;
  int kept_ = -1;
};

// Where the last line of a process goes that ends while one of them lives.
int standard_error();

}  // namespace physmas

#endif
