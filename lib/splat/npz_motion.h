// A motion of Gaussians as arrays for Python.
#ifndef PHYSMAS_SPLAT_NPZ_MOTION_H
#define PHYSMAS_SPLAT_NPZ_MOTION_H

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/file.h"
#include "scene/gaussians.h"

namespace physmas::splat {

// A .npz file (numpy.load) of T frames of N Gaussians, in scene space, not compressed: positions [T, N, 3], rotations
// [T, N, 4] (w x y z, of length 1), scales [T, N, 3] (linear), opacities [N], harmonics [N, K, 3] at rest, float32;
// frames [T], int32; times [T], float64, s; rows [N], int32, the row of the inventory or -1.
class NpzMotion {
 public:
  // frames: how many there will be, at least one. rows: [N].
  NpzMotion(const std::string& path, size_t frames, const Gaussians& rest, const std::vector<int32_t>& rows);
  void add(int frame, double time, const Gaussians& gaussians);
  // After all frames. Returns whether the file changed.
  bool commit();

 private:
  // An array that grows frame by frame at its place.
  struct Entry {
    std::string name;
    uint64_t local = 0, data = 0, size = 0, filled = 0;  // bytes of the file
    uint32_t crc = 0;
  };
  Entry& begin(const std::string& name, const char* type, const std::vector<size_t>& shape, size_t element_bytes);
  void fill(Entry& entry, const void* bytes, size_t count);

  FileWriter file_;
  std::vector<Entry> entries_;
  size_t frames_ = 0;
};

}  // namespace physmas::splat

#endif
