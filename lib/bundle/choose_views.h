// Four of many captured views.
#ifndef PHYSMAS_BUNDLE_CHOOSE_VIEWS_H
#define PHYSMAS_BUNDLE_CHOOSE_VIEWS_H

#include <array>
#include <string>
#include <vector>

#include "bundle/captured_views.h"

namespace physmas::bundle {

struct ChosenView {
  size_t index = 0;  // into the captured views
  double angle = 0;  // degrees between where it stands, seen from the scene's centre, and its direction
};

// The views that stand for front, right, back and left (kViewNames), four different ones. From the scene's centre, the
// centre of the box around `points`, each camera has a direction; among the cameras whose image contains that centre,
// the four are taken whose directions have the largest sum of cosines with the four horizontal directions of
// scene_axes(up, front). Ties go to the camera that comes first in the file. front_view: index of the view that must be
// the front, or -1. Throws an Error (exit code 3, naming `file`) when fewer than four cameras see the centre, or the
// front view does not.
std::array<ChosenView, 4> choose_views(const std::vector<CapturedView>& views,
                                       const std::vector<Eigen::Vector3d>& points, const std::string& up,
                                       const std::string& file, double front = 0, int front_view = -1);

}  // namespace physmas::bundle

#endif
