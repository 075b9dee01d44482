#include "bind/start.h"

namespace physmas::bind {

std::optional<mpm::Equilibrium> bind_start(const RunSpecification::Time& time, const Device& device,
                                           mpm::Problem& problem) {
  if (time.start != RunSpecification::Time::Start::equilibrium) return std::nullopt;
  mpm::Equilibrium found = mpm::find_equilibrium(problem, device);
  problem.particles.deformation_gradient = found.deformation_gradient;
  return found;
}

StartRecord start_record(const mpm::Equilibrium& equilibrium, const std::vector<std::string>& row_keys) {
  StartRecord record;
  record.supported_parts = equilibrium.supported_parts;
  record.free_parts = equilibrium.free_parts;
  record.supported_particles = static_cast<long>(equilibrium.supported_particles);
  record.iterations = equilibrium.iterations;
  record.corrections = equilibrium.corrections;
  record.residual = equilibrium.residual;
  record.largest_strain = equilibrium.largest_strain;
  for (size_t r = 0; r < equilibrium.limited.size(); ++r) {
    if (equilibrium.limited[r] > 0)
      record.limited.emplace_back(row_keys.at(r), static_cast<long>(equilibrium.limited[r]));
  }
  return record;
}

}  // namespace physmas::bind
