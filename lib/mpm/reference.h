// The substep in the paper's own words: plain loops over particles and their 27 nodes, in double precision, phase by
// phase. Slow; what the passes of the back ends, which fuse the phases, are tested against.
#ifndef PHYSMAS_MPM_REFERENCE_H
#define PHYSMAS_MPM_REFERENCE_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/state.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm::reference {

// All nodes of the grid: node (i, j, k) is number (i (n + 1) + j) (n + 1) + k and lies at dx (i, j, k).
struct Grid {
  explicit Grid(const Domain& domain);

  int nodes;                    // per axis, n + 1
  std::vector<double> mass;     // m_a [kg]
  std::vector<Vec3d> momentum;  // p_a [kg m/s]
  std::vector<Vec3d> velocity;  // u_a [m/s]; zero where there is no mass
};

// The velocity that an action adds to where a particle and its deformation advance: its position increment.
struct Increment {
  Vec3d velocity;  // m/s
  Mat3d gradient;  // 1/s
};

// controls: per control group, as ActionPlan gives them. dt: [s].

// Actions, first part: blends velocities and affine maps with the fields, and adds what forces change.
void blend_actions(const StepperSetup& setup, const std::vector<Control>& controls, State& state);
// Masses and momenta of the nodes, with dt times the stress force (paper, Eq. "p2g"), of the rows of one body.
Grid p2g(const StepperSetup& setup, const State& state, double dt, int body = 0);
// Velocities u_a = p_a / m_a (Eq. "gridupdate"), then gravity.
void grid_update(const Domain& domain, double dt, Grid& grid);
// Where nodes have mass of several bodies. grids: per body.
void meet(const StepperSetup& setup, std::vector<Grid>& grids);
// Colliders, then walls.
void contact(const Domain& domain, Grid& grid);
// Velocities and affine maps B_q of the particles. grids: per body.
void g2p(const StepperSetup& setup, const std::vector<Grid>& grids, State& state);
// Actions, second part: enforced motion overrules G2P. Returns the position increments, [N].
std::vector<Increment> enforce_actions(const StepperSetup& setup, const std::vector<Control>& controls, State& state);
// Places, F and total F advance.
void move(const StepperSetup& setup, const std::vector<Increment>& increments, double dt, State& state);
// F, and the strength of Plasticine, back to the yield surface.
void return_map(const StepperSetup& setup, double dt, State& state);

// All of them, in this order.
void substep(const StepperSetup& setup, const std::vector<Control>& controls, double dt, State& state);

}  // namespace physmas::mpm::reference

#endif
