// Files for readers that take a path: in memory, one folder per process, removed at its end.
#ifndef PHYSMAS_TESTS_FUZZ_SCRATCH_H
#define PHYSMAS_TESTS_FUZZ_SCRATCH_H

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace physmas {

class Scratch {
 public:
  Scratch() { std::filesystem::create_directories(folder_); }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  const std::string& folder() const { return folder_; }
  std::string operator/(const std::string& name) const { return folder_ + "/" + name; }
  // Returns the path.
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = *this / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

 private:
  std::string folder_ = "/dev/shm/physmas-fuzz-" + std::to_string(getpid());
};

}  // namespace physmas

#endif
