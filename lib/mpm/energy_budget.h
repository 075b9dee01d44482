// Where the energy of a substep goes, term by term. Measured only when asked for.
//
// The energy of a state is kinetic (with the affine part of APIC) + elastic + gravity. In one substep
//   change = control + projection + contact + rigid − transfer − plastic − viscous + residual.
// Transfer losses are never negative: P2G is an average of the particles' affine fields at a node (Jensen), G2P an
// orthogonal projection of node velocities onto one affine field (Jiang et al. 2015). What is left over is the error of
// the time integration, of second order in dt for one step and of first order for a given time.
#ifndef PHYSMAS_MPM_ENERGY_BUDGET_H
#define PHYSMAS_MPM_ENERGY_BUDGET_H

#include <algorithm>
#include <cmath>

namespace physmas::mpm {

// Sums over substeps [J].
struct EnergyBudget {
  double change = 0;      // of kinetic + elastic + gravity
  double transfer = 0;    // lost between particles and grid
  double contact = 0;     // put in by walls and colliders: negative, friction and inelastic impact
  double plastic = 0;     // lost in return maps
  double viscous = 0;     // lost to Foam's flow resistance beyond its yield strength
  double projection = 0;  // put in by the stress cone of Sand, Snow and Plasticine, which has no potential
  double control = 0;     // put in by actions
  double structure = 0;   // put in by structure projection and interface retention at output frames
  double rigid = 0;       // put in by what keeps rigid bodies rigid: negative, the loss of their impacts
  double largest_step_residual = 0;

  double residual() const {
    return change - (control + structure + projection + contact + rigid - transfer - plastic - viscous);
  }
  void add(const EnergyBudget& b) {
    change += b.change, transfer += b.transfer, contact += b.contact, plastic += b.plastic, viscous += b.viscous;
    projection += b.projection, control += b.control, structure += b.structure, rigid += b.rigid;
    largest_step_residual = std::max(largest_step_residual, b.largest_step_residual);
  }
};

// What particles report from one pass [J].
struct ParticleEnergy {
  double gathered = 0;        // kinetic, as it comes from the grid
  double rigid = 0;           // the part of it that is rigid motion
  double state = 0;           // kinetic + elastic + gravity after controls
  double scattered = 0;       // kinetic, as it goes to the grid
  double plastic = 0;         // lost
  double viscous = 0;         // lost
  double projection = 0;      // put in
  double control_after = 0;   // put in by enforced velocities after G2P
  double control_before = 0;  // put in by controls before the next P2G

  void add(const ParticleEnergy& e) {
    gathered += e.gathered, state += e.state, scattered += e.scattered, plastic += e.plastic, viscous += e.viscous;
    rigid += e.rigid;
    projection += e.projection, control_after += e.control_after, control_before += e.control_before;
  }
};

// What nodes report [J].
struct GridEnergy {
  double arrived = 0;     // kinetic, as particles brought it
  double left = 0;        // kinetic, after forces, gravity and contact
  double contact = 0;     // put in by walls and colliders
  double rigid = 0;       // put in by the lock of rigid bodies
  double rigid_left = 0;  // the part of `left` that belongs to their masses

  void add(const GridEnergy& e) {
    arrived += e.arrived, left += e.left, contact += e.contact, rigid += e.rigid, rigid_left += e.rigid_left;
  }
};

// Adds one node. Each of its numbers is a vector {·, x, y, z}; arrived: {mass, momentum without forces}; free, left:
// velocity before and after contact. Contact works along the mean of the first and the last velocity, so that a node
// which rests on a floor costs nothing.
template <class T>
void measure_node(const T* arrived, const T* free, const T* left, GridEnergy& out) {
  const double mass = arrived[0];
  if (!(mass > 0)) return;
  for (int a = 1; a <= 3; ++a) {
    const double u0 = arrived[a] / mass, u3 = left[a];
    out.arrived += 0.5 * mass * u0 * u0;
    out.left += 0.5 * mass * u3 * u3;
    out.contact += 0.5 * mass * (u3 - free[a]) * (u0 + u3);
  }
}

// Adds up substeps: `begin` with the first pass of an interval, then `grid` and `finish` for every substep.
class EnergyLedger {
 public:
  void begin(const ParticleEnergy& e) { before_ = e, total_ = {}; }
  // After a substep whose particles did not go on to the next in the same pass.
  void resume(const ParticleEnergy& e) { before_ = e; }
  void grid(const GridEnergy& e) { grid_ = e; }
  void finish(const ParticleEnergy& e) {
    EnergyBudget step;
    step.change = e.state - before_.state;
    // A body's nodes move with the rigid motion that fits them, and not with an average.
    const double fit = e.rigid - grid_.rigid_left;
    step.transfer = (before_.scattered - grid_.arrived) + (grid_.left - (e.gathered - fit));
    step.rigid = grid_.rigid + fit;
    step.contact = grid_.contact;
    step.plastic = e.plastic, step.viscous = e.viscous, step.projection = e.projection;
    step.control = before_.control_before + e.control_after;
    step.largest_step_residual = std::fabs(step.residual());
    total_.add(step);
    before_ = e;
  }
  const EnergyBudget& total() const { return total_; }

 private:
  ParticleEnergy before_;
  GridEnergy grid_;
  EnergyBudget total_;
};

}  // namespace physmas::mpm

#endif
