#include "mpm/body_contact.h"

#include <algorithm>
#include <cmath>

namespace physmas::mpm {

namespace {

// A third body may be pushed by what two others have settled; some rounds come close to what satisfies all three.
constexpr int kRounds = 4;

void meet(BodyAtNode& a, BodyAtNode& b, double friction) {
  // From a into b. Of relative gradients, so that a dense body does not decide alone where the two touch.
  const Vec3d between = (1 / b.mass) * b.mass_per_dx - (1 / a.mass) * a.mass_per_dx;
  const double length = norm(between);
  const Vec3d approach = a.u - b.u;
  Vec3d lost = approach;  // bodies that lie in each other have no side to part to
  if (length > 0) {
    const Vec3d n = (1 / length) * between;
    const double closing = dot(approach, n);
    if (!(closing > 0)) return;
    const Vec3d sliding = approach - closing * n;
    const double speed = norm(sliding);
    lost = closing * n + (speed > friction * closing ? friction * closing / speed : 1) * sliding;
  }
  const double whole = a.mass + b.mass;
  a.u = a.u - (b.mass / whole) * lost;
  b.u = b.u + (a.mass / whole) * lost;
}

}  // namespace

int BodyContact::bodies() const {
  return body.empty() ? 1 : 1 + *std::max_element(body.begin(), body.end());
}

void meet(BodyAtNode* bodies, int count, double friction) {
  for (int round = 0; round < (count > 2 ? kRounds : 1); ++round) {
    for (int a = 0; a < count; ++a) {
      for (int b = a + 1; b < count; ++b) meet(bodies[a], bodies[b], friction);
    }
  }
}

}  // namespace physmas::mpm
