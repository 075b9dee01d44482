// Problems with an analytic or independent answer, as functions of what is refined. All in double precision.
#ifndef PHYSMAS_STUDIES_VERIFICATION_CASES_H
#define PHYSMAS_STUDIES_VERIFICATION_CASES_H

#include <functional>

#include "mpm/simulation.h"

namespace physmas::studies {

// Adds particles on a lattice of the given spacing [m], centred in [low, high], where `inside` says so.
void seed(mpm::Problem& problem, const mpm::Vec3d& low, const mpm::Vec3d& high, double spacing, int row,
          const std::function<bool(const mpm::Vec3d&)>& inside = {});

// n: cells per axis of the domain of edge 2 m; dt: substep [s], rounded so that substeps fill an output frame.
// A run that diverges throws internal_error.

// Falls for 0.2 s from rest. Largest distance to z0 - g t²/2 [m]; g t dt / 2 for symplectic Euler.
double free_fall_error(double dt, const Device& device = {});

// A cube that turns at 2π rad/s about an oblique axis for one turn of 1 s.
struct Rotation {
  double momentum_drift = 0;  // |L(end) - L(0)| / |L(0)|, the affine part of APIC included
  double angle_error = 0;  // against 2π I / (I + m dx²/2): the affine fields start at rest and take their share [rad]
};
Rotation rigid_rotation(int n, double dt, const Device& device = {});

// Lowest longitudinal mode of a free bar of 1 m, ν = 0: measured frequency / (c / 2L), c = sqrt(E/ρ).
double bar_frequency(int n, double dt, const Device& device = {});

// A column of 0.8 m on a frictionless floor, loaded by gravity at once, ν = 0. Mean displacement over the first period
// of 4H/c, in which every mode has whole periods, against the static ρg/E (H Z − Z²/2): largest error / static
// settlement of the top.
double column_error(int n, double dt, const Device& device = {});

// Two equal Jelly balls of radius 0.2 m that meet head-on at ±0.5 m/s (a twentieth of the wave speed).
struct Collision {
  double momentum_error = 0;  // |change of the total momentum| / momentum of one ball
  double restitution = 0;     // relative speed of the centres after / before
};
Collision ball_collision(int n, double dt, const Device& device = {});

// A block on a plane of Coulomb friction, gravity tilted by the angle [degrees]. Acceleration along the plane, mean
// over 0.12 to 0.28 s, in units of g.
double incline_acceleration(int n, double dt, double friction, double angle, const Device& device = {});

// A quarter of a cylinder of Sand of radius 0.4 m and height a × 0.4 m, between two frictionless planes, collapses on a
// rough floor for 1.2 s. (r∞ − r0) / r0, r∞ the
// radius that holds 99 % of the particles. alpha: slope of the stress cone; 0.16 is the paper's, 0.327 makes it
// coincide with the return map at 30 degrees.
double sand_run_out(int n, double dt, double aspect, double alpha, const Device& device = {});
// Lube et al. 2004: 1.24 a below a = 1.7, 1.6 sqrt(a) above.
double lube_run_out(double aspect);

// A block thrown at a rough floor: |residual| of the energy budget after 0.12 s / initial kinetic energy.
double energy_residual_of_throw(mpm::Branch branch, double dt, const Device& device = {});

}  // namespace physmas::studies

#endif
