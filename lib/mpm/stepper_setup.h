// What a stepper is made from: everything that stays the same during a run.
#ifndef PHYSMAS_MPM_STEPPER_SETUP_H
#define PHYSMAS_MPM_STEPPER_SETUP_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mpm/body_contact.h"
#include "mpm/domain.h"
#include "mpm/material/material.h"
#include "mpm/rigid/rigid_setup.h"

namespace physmas::mpm {

struct StepperSetup {
  Domain domain;
  BodyContact contact;
  std::vector<Branch> branches;                        // per row
  std::vector<MaterialParameters<double>> parameters;  // per row
  std::vector<ParticleElasticity<double>> elasticity;  // per particle, or empty: each has its row's
  std::vector<int> row;                                // per particle
  std::vector<double> volume;                          // per particle [m^3]
  std::vector<std::uint16_t> control_group;            // per particle
  RigidSetup rigid;            // where it has bodies, each has the field of contact 1 + its index, and all else field 0
  bool track_total_F = false;  // State::total_F is integrated as well
  bool measure_steps = false;  // the energy budget of every substep

  MaterialParameters<double> parameters_of(std::size_t particle) const {
    const MaterialParameters<double>& own = parameters[row[particle]];
    return elasticity.empty() ? own : with_elasticity(own, elasticity[particle]);
  }
};

}  // namespace physmas::mpm

#endif
