// The execution score Q_exec and its features (paper, "Validity Gate, Ranking, and Tie Rules", Eq. supp-critic).
#ifndef PHYSMAS_SCREEN_SCORE_H
#define PHYSMAS_SCREEN_SCORE_H

#include <array>
#include <optional>
#include <vector>

#include "records/candidate.h"
#include "records/evidence.h"
#include "records/execution.h"
#include "records/inventory.h"
#include "records/plan.h"
#include "records/render.h"
#include "records/run_specification.h"
#include "records/screen.h"

namespace physmas::screen {

// What every candidate of a scene is judged with.
struct SceneRecords {
  const Inventory& inventory;
  const Evidence& evidence;
  const Plan& plan;
  int frames = 0;                                                         // T, the rest frame included
  double tau = 0;                                                         // acceptance threshold
  std::array<double, 7> weights = RunSpecification::Screening().weights;  // of the features, in the order of phi
  bool excuse_rotation = true;  // what is neither spread nor flattened in the objects' own frame passes
  double achieved_min = 0;                                                // 0: no gate
  std::optional<double> stillness_min;                                    // empty: as the plan asks
  // How still what nothing moves must stand; 0: no gate. A prompt that asks for no motion is not met by half of it.
  double least_stillness() const { return stillness_min.value_or(plan.still ? 0.5 : 0); }
};

// An executed candidate.
struct Executed {
  Candidate candidate;
  ExecutionRecord execution;
  RenderRecord render;
};

// First and last foreground: frames 0 and T-1 in the first output camera. Not valid when one of them is missing or
// empty.
struct Endpoints {
  bool valid = false;
  ForegroundRatios image;
  double dark_ratio = 0;  // of the last frame
  // In the objects' own frame, where the record has it and its boxes are not empty. Of spread: every object turned
  // back; of flattening: also put back.
  std::optional<ForegroundRatios> own_spread, own_flattening;
  bool excuse = true;  // what fails in the image passes where both ratios hold in the objects' own frame

  // Both hold there: what kept its shape may fail in the image, what melts while it falls towards the camera may not.
  bool excused() const {
    return excuse && own_spread && own_flattening && !own_spread->spread() && !own_flattening->flattened();
  }
  bool spread() const { return image.spread() && !excused(); }
  bool flattened() const { return image.flattened() && !excused(); }
  // Of the tiers of the score.
  double area_growth() const { return image.spread() && excused() ? own_spread->area_growth : image.area_growth; }
};
Endpoints endpoints_of(const RenderRecord& render, const SceneRecords& scene);

// Fills features, video terms, penalty and score, and what stands beside it: the shares of the requests that were met,
// of which the smallest counts. A mean would hide the one action that was not done behind the others, and a video shows
// what was asked only when it shows all of it.
void score_candidate(ScreenedCandidate& screened, const Executed& executed, const SceneRecords& scene);

}  // namespace physmas::screen

#endif
