// Signs drawn over a picture where a candidate's actions act: arrows, a flat disc that presses, pins that hold.
#ifndef PHYSMAS_SPLAT_ACTION_SIGNS_H
#define PHYSMAS_SPLAT_ACTION_SIGNS_H

#include <Eigen/Core>
#include <vector>

#include "records/candidate.h"
#include "records/state.h"
#include "scene/camera.h"
#include "scene/gaussians.h"
#include "scene/image.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

constexpr double kShortestSign = 0.16;  // seconds that a sign is seen at least: an impulse is shorter than a frame

// A sign stands at the box of what its action acts on, in the frame as it is: an arrow behind what is pushed or hit and
// before what is pulled, arrows outwards or inwards at what is stretched, shortened or spread, an arrow around what is
// turned, a disc on what is pressed, pins in what is held. Equal actions on several rows have one sign. It is seen from
// the action's start to its end. The box is that of the middle 96 % of the rows' Gaussians per axis; an action of rows
// without any has no sign.
class ActionSigns {
 public:
  // candidate: whose schedule; its rows are those of `state`. gaussians: at rest. up: unit, scene axes.
  ActionSigns(const Candidate& candidate, const State& state, const Gaussians& gaussians, const Eigen::Vector3d& up);

  // Draws the signs of time `time` [s] over `picture`, RGB, which shows `frame` in `camera`.
  void draw(const TransportedFrame& frame, double time, const Camera& camera, Image& picture) const;

 private:
  struct Acting {
    ScheduleOperation operation;
    std::vector<size_t> gaussians;  // that it acts on
  };
  std::vector<Acting> acting_;
  Eigen::Vector3d up_;
  double size_;  // of the scene at rest, scene units
};

}  // namespace physmas::splat

#endif
