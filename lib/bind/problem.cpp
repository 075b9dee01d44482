#include "bind/problem.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "bind/contact.h"
#include "bind/domain.h"
#include "bind/materials.h"
#include "bind/schedule.h"

namespace physmas::bind {

mpm::Particles bind_particles(const State& state) {
  mpm::Particles particles;
  particles.position.reserve(state.particle_count());
  for (const Eigen::Vector3f& x : state.position) particles.position.push_back({x.x(), x.y(), x.z()});
  particles.volume.assign(state.volume.begin(), state.volume.end());
  particles.row.assign(state.row.begin(), state.row.end());
  return particles;
}

mpm::Problem bind_problem(const Candidate& candidate, const State& state, const RunSpecification& run,
                          const ProblemFiles& files) {
  if (std::abs(run.grid.length - state.map.length) > 1e-12) {
    throw invalid_input({files.state, "/map/@L", fmt::format("{}", state.map.length),
                         fmt::format("{}, the run's grid length", run.grid.length),
                         "make the state again with pm-lift"});
  }
  mpm::Problem problem;
  problem.domain = bind_domain(run);
  problem.materials = bind_materials(candidate, state, files.candidate);
  problem.object = bind_objects(state);
  problem.constants = bind_constants(run.profile);
  problem.contact = bind_contact(state, run.contact);
  problem.particles = bind_particles(state);
  problem.particles.material = bind_particle_materials(candidate, state, problem.materials);
  problem.schedule = bind_schedule(candidate, run);
  return problem;
}

}  // namespace physmas::bind
