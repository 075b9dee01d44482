// The 4D viewer: a rollout in one file that a browser plays, as pm-render --html writes it and a run's report holds it.
#ifndef PHYSMAS_REPORT_VIEWER_H
#define PHYSMAS_REPORT_VIEWER_H

#include <string>

#include "records/cameras.h"
#include "records/candidate.h"
#include "records/execution.h"
#include "records/json.h"
#include "records/scene.h"
#include "records/state.h"
#include "report/stream.h"

namespace physmas::report {

struct Viewer {
  Json header;        // what lib/report/pages/viewer.js is given beside the stream
  std::string about;  // one sentence: what is shown, what was left out, and how exact it is
  std::string bytes;  // the stream
};

// What a viewer is made of. inventory: names and residual rows; null: keys. candidate: moduli, for colours of stress;
// null: none.
struct ViewerSource {
  const Scene& scene;
  const State& state;
  const Gaussians& gaussians;
  const splat::RolloutFrames& rollout;
  const FittedCameras& cameras;
  const Inventory* inventory = nullptr;
  const Candidate* candidate = nullptr;
  std::string name;  // of the candidate
};
Viewer make_viewer(const ViewerSource& source, const StreamLimits& limits = {});

struct ViewerFiles {
  std::string scene, state, rollout;          // as pm-render takes them
  std::string cameras, candidate, inventory;  // or empty
  std::string out;                            // .html
};
// Writes the viewer as a page of its own. Errors (exit code 3) as render_rollout has them.
void write_viewer_page(const ViewerFiles& files);

}  // namespace physmas::report

#endif
