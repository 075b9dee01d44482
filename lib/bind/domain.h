// From a run specification to the box that is simulated.
#ifndef PHYSMAS_BIND_DOMAIN_H
#define PHYSMAS_BIND_DOMAIN_H

#include "mpm/domain.h"
#include "records/run_specification.h"

namespace physmas::bind {

// Grid, gravity, walls and colliders, in their order. A box collider becomes its centre and half edges.
mpm::Domain bind_domain(const RunSpecification& run);

}  // namespace physmas::bind

#endif
