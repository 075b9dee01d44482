// Particles take the numbers of a material field's nearest samples.
#ifndef PHYSMAS_LIFT_MATERIAL_SAMPLES_H
#define PHYSMAS_LIFT_MATERIAL_SAMPLES_H

#include <string>

#include "records/material_field.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::lift {

// For every particle of the state the sample nearest to it under N, the lowest index on ties, where that lies within
// reach: lifting.field_reach cells, or, where the run does not say, twice the median distance of a sample from its
// nearest one, and two cells at least. file: the field's, for the Error (exit code 3) when no particle has a sample.
ParticleField sample_particles(const MaterialField& field, const State& state, const RunSpecification& run,
                               const std::string& file);

}  // namespace physmas::lift

#endif
