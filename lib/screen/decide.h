// The decision of a round: ranking, admission, repair base and routes.
#ifndef PHYSMAS_SCREEN_DECIDE_H
#define PHYSMAS_SCREEN_DECIDE_H

#include <string>
#include <vector>

#include "screen/score.h"

namespace physmas::screen {

// Repairs that a candidate's diagnostics ask for, in the fixed order: support -> support repairs; spread or flattening
// -> cohesion repairs; error token or failed process -> solver stability; nothing else and a score below tau -> role
// balancing.
std::vector<std::string> route_repairs(const ScreenedCandidate& screened, double tau);

// Scores, gates and ranks `executed` (order of first appearance, which breaks ties) and decides the round: accept the
// best admitted candidate (subject to the audit), else repair the best of all executed while another round remains,
// else fail. rounds: how many there may be.
ScreenRecord decide_round(const std::vector<Executed>& executed, const SceneRecords& scene, int round, int rounds);

}  // namespace physmas::screen

#endif
