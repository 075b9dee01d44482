#include "mpm/balance.h"

#include <algorithm>
#include <cmath>

namespace physmas::mpm {

Balance measure_balance(const StepperSetup& setup, const State& state) {
  Balance b;
  const double dx = setup.domain.dx();
  // An APIC particle carries the angular momentum of its affine field: inertia m dx²/4 per axis (Jiang et al. 2015).
  const double spread = dx * dx / 4;
  const double wall_low = (setup.domain.wall_cells + 1.5) * dx;
  const double wall_high = setup.domain.length - wall_low;
  for (size_t i = 0; i < state.size(); ++i) {
    const double m = setup.parameters_of(i).density * setup.volume[i];
    const Vec3d& x = state.x[i];
    const Vec3d& v = state.v[i];
    const Mat3d& C = state.C[i];
    const Vec3d spin = {C[2][1] - C[1][2], C[0][2] - C[2][0], C[1][0] - C[0][1]};
    b.mass += m;
    b.kinetic += 0.5 * m * dot(v, v);
    b.affine += 0.5 * m * spread * squared_norm(C);
    b.gravity -= m * dot(setup.domain.gravity, x);
    b.momentum = b.momentum + m * v;
    b.angular_momentum = b.angular_momentum + m * (cross(x, v) + spread * spin);
    b.max_speed = std::max(b.max_speed, norm(v));
    const double low = std::min({x.x, x.y, x.z}), high = std::max({x.x, x.y, x.z});
    b.at_wall += low < wall_low || high > wall_high;
  }
  return b;
}

bool EnergyWatch::surplus(const Balance& b) {
  constexpr double kTolerance = 0.1;  // stable runs stay below 0.001 (make stability)
  fall_ = std::max(fall_, std::fabs(b.gravity - start_.gravity));
  const double total = b.kinetic + b.recoverable + b.gravity;
  const double gain = total - (start_.kinetic + start_.elastic + start_.gravity) - 2 * b.control_work;
  return gain > kTolerance * (scale_ + fall_ + b.control_work);
}

}  // namespace physmas::mpm
