// The execution score Q_exec and its features (paper, "Validity Gate, Ranking, and Tie Rules", Eq. supp-critic).
#ifndef PHYSMAS_SCREEN_SCORE_H
#define PHYSMAS_SCREEN_SCORE_H

#include <array>
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
};

// An executed candidate.
struct Executed {
  Candidate candidate;
  ExecutionRecord execution;
  RenderRecord render;
};

// Limits of the spread and flattening gates (paper, "Validity Gate, Ranking, and Tie Rules"); two terms of the score
// have the same ones.
constexpr double kSpreadLimit = 2.0;  // foreground-box area, last over first
constexpr double kFlatHeight = 0.45, kFlatWidth = 1.25;

// First and last foreground boxes: frames 0 and T-1 in the first output camera. Not valid when one of them is missing
// or empty.
struct Endpoints {
  bool valid = false;
  double area_growth = 0;   // last over first, box width x height
  double height_ratio = 0;  // last over first
  double width_ratio = 0;
  double dark_ratio = 0;  // of the last frame

  bool spread() const { return area_growth > kSpreadLimit; }
  bool flattened() const { return height_ratio < kFlatHeight && width_ratio > kFlatWidth; }
};
Endpoints endpoints_of(const RenderRecord& render, int frames);

// Fills features, video terms, penalty and score.
void score_candidate(ScreenedCandidate& screened, const Executed& executed, const SceneRecords& scene);

}  // namespace physmas::screen

#endif
