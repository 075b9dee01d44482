// The validity gate: what a candidate must satisfy besides its score.
#ifndef PHYSMAS_SCREEN_GATES_H
#define PHYSMAS_SCREEN_GATES_H

#include "screen/score.h"

namespace physmas::screen {

// Fills `gates` (each with its measured value and limit) and `valid`. Spread and flattening pass without valid
// endpoints; the support gate passes without a support row, and for the solver-compatible transform itself. The gates
// of what was achieved and of stillness are there only where the run asks for them, stillness also where the prompt asks
// for no motion, and pass where nothing was measured.
// The score comes first (score_candidate).
void check_gates(ScreenedCandidate& screened, const Executed& executed, const SceneRecords& scene);

// Whether the named gate of a checked candidate passed.
bool gate_passed(const ScreenedCandidate& screened, const char* name);

}  // namespace physmas::screen

#endif
