// Mathematical constants.
#ifndef PHYSMAS_BASE_CONSTANTS_H
#define PHYSMAS_BASE_CONSTANTS_H

namespace physmas {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRootTwoThirds = 0.81649658092772603;  // √(2/3): |dev τ| at a von Mises strength of one

}  // namespace physmas

#endif
