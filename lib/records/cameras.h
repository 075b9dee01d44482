// cameras/roundN.json: the cameras of a run's videos, fitted to where things are (run specification, render.camera).
#ifndef PHYSMAS_RECORDS_CAMERAS_H
#define PHYSMAS_RECORDS_CAMERAS_H

#include <limits>
#include <string>
#include <vector>

#include "records/camera.h"
#include "records/provenance.h"
#include "records/run_specification.h"

namespace physmas {

// How far things reach beyond the planes through a camera's centre that bound its picture, less a margin: the largest
// x - t z of their points (and of what a splat reaches around them), where x points to that edge, z forward and t is
// the edge's tangent. Scene units; not above 0 when everything is inside.
struct PictureReach {
  static constexpr double kNothing = -std::numeric_limits<double>::infinity();
  double right = kNothing, left = kNothing, down = kNothing, up = kNothing;
};

struct FittedCameras {
  RunSpecification::Render::CameraMode mode = RunSpecification::Render::CameraMode::fit;
  std::vector<Camera> cameras;  // one, or one per output frame
  double distance = 1;          // of the camera from the scene's middle, over that of the scene's own camera; >= 1
  // In the scene's own cameras, turned where they turn: of all frames of all candidates so far, and of the rest frame.
  PictureReach reach, rest;
  std::vector<std::string> candidates;  // whose motion is seen
  std::vector<Omission> omitted;

  // The camera of output frame t.
  const Camera& camera(int t) const { return cameras.size() == 1 ? cameras[0] : cameras.at(t); }
};

FittedCameras load_cameras(const std::string& path);
void save_cameras(const std::string& path, const FittedCameras& cameras, const Provenance& provenance);

}  // namespace physmas

#endif
