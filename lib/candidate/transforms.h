// The initial candidates and the repairs of Table "candidatetransforms": rows and controls.
#ifndef PHYSMAS_CANDIDATE_TRANSFORMS_H
#define PHYSMAS_CANDIDATE_TRANSFORMS_H

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "candidate/context.h"

namespace physmas::candidate {

// Names are file names and ids; the order is the paper's.
inline constexpr std::array<const char*, 10> kInitialTransforms = {
    "posterior", "target-impact", "hard-support-bonded", "support-stiff",       "solver-compatible", "rigid-support",
    "soft",      "stiff",         "uncertainty-sweep",   "alternative-material"};

// What a transform T_c decides: rows of every active row, and U_aux (paper, Eq. candidateconstruction).
struct Configuration {
  std::vector<CandidateRow> rows;
  std::vector<std::pair<std::string, double>> projection;  // support row key -> eta
  std::vector<std::string> retention;                      // support row keys
};
bool operator==(const Configuration& a, const Configuration& b);
Configuration configuration_of(const Candidate& candidate);

// Rows and controls of an initial transform; empty, with the reason in `why`, when it is not emitted.
std::optional<Configuration> transform(const Context& context, const std::string& name, std::string& why);

// Metal, 1e7 Pa, nu at most 0.35, rho at least 1000: the support line of several transforms and repairs.
CandidateRow stiff_support(CandidateRow row);
constexpr double kSupportE = 1e7;  // Pa

// What the user stated of rows (EvidenceRow::stated) stands in place of what a transform or a repair made of it.
void keep_stated(const Context& context, Configuration& configuration);

// Rows and controls of a repair of `base`. Fields that the repair does not name keep the base's values.
Configuration repair(const Context& context, const std::string& name, const Candidate& base);

}  // namespace physmas::candidate

#endif
