// Mathematical constants.
#ifndef PHYSMAS_BASE_CONSTANTS_H
#define PHYSMAS_BASE_CONSTANTS_H

namespace physmas {

constexpr double kPi = 3.14159265358979323846;

}  // namespace physmas

#endif
