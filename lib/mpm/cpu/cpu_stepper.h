// The stepper of the CPU: particles in SIMD lanes, blocks of the grid shared by threads.
#ifndef PHYSMAS_MPM_CPU_CPU_STEPPER_H
#define PHYSMAS_MPM_CPU_CPU_STEPPER_H

#include "mpm/stepper.h"

namespace physmas::mpm {

// threads: at most so many, 0: all cores; fewer where there are few particles.
std::unique_ptr<Stepper> make_cpu_stepper(int threads, Precision precision, const StepperSetup& setup);

}  // namespace physmas::mpm

#endif
