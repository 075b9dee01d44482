// The Z-order curve: neighbours in space are neighbours in a list.
#ifndef PHYSMAS_LIFT_CURVE_H
#define PHYSMAS_LIFT_CURVE_H

#include <Eigen/Core>
#include <cstdint>

namespace physmas::lift {

// Position on the curve of the cell `c`, 21 bits per axis. Cells 2^k times as large are the positions without their
// last 3 k bits.
inline uint64_t curve_position(const Eigen::Vector3i& c) {
  uint64_t code = 0;
  for (int bit = 0; bit < 21; ++bit) {
    for (int a = 0; a < 3; ++a) code |= (static_cast<uint64_t>(c[a] >> bit) & 1) << (3 * bit + a);
  }
  return code;
}

}  // namespace physmas::lift

#endif
