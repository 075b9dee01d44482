// The solver against analytic and independent answers, under refinement: `pm-eval verification`.
#ifndef PHYSMAS_STUDIES_VERIFICATION_H
#define PHYSMAS_STUDIES_VERIFICATION_H

#include <string>
#include <vector>

#include "base/device.h"

namespace physmas::studies {

// One measured quantity at one resolution.
struct VerificationRow {
  std::string name;        // "bar: frequency / analytic"
  std::string resolution;  // "n = 32"
  double expected = 0;
  double measured = 0;
  double order = 0;    // observed order of the error since the row before; 0 where there is none to speak of
  std::string source;  // where the expected value comes from

  double error() const { return measured - expected; }
};

// Runs every case; about a minute on two cores, or, `quick`, the coarsest resolutions in a few seconds.
std::vector<VerificationRow> verify(bool quick, const Device& device);

// A table for people.
std::string verification_table(const std::vector<VerificationRow>& rows);

}  // namespace physmas::studies

#endif
