// The user's own calibrated images, for a bundle.
#ifndef PHYSMAS_BUNDLE_USER_VIEWS_H
#define PHYSMAS_BUNDLE_USER_VIEWS_H

#include <string>
#include <utility>
#include <vector>

#include "bundle/dataparser_transform.h"
#include "records/scene.h"

namespace physmas::bundle {

// A file that goes into the bundle as it is.
struct CopiedFile {
  std::string to;
  std::string bytes;
};

struct UserViews {
  std::vector<SceneView> views;  // four
  std::vector<CopiedFile> files;
  // What the record shall say: per view "front" and "images/0001.png, 3.2 degrees off". Empty for our own list.
  std::vector<std::pair<std::string, std::string>> chosen;
  bool transformed = false;  // by `dataparser`
  double front = 0;          // degrees about up at which the front view stands (scene_axes)
};

// cameras: our own list of exactly four {name, image, camera}, or a file of load_captured_views, from which
// choose_views takes four. Images lie in `folder` under the name that the file gives, with or without its folders, and
// with an extension .png, .jpg or .jpeg where the name has none. Images of other programs may be smaller or larger than
// their cameras say when both sides differ by one factor; the camera is scaled. Those of lenses with distortion are
// undistorted and become PNG. front: what --front says: degrees or an axis (front_degrees), by which the choice is
// made; the name of the view or image that is the front; or empty. Of our own list, the view that is named or stands
// nearest comes first and the others follow in the order of the list, begun again at its end. dataparser: a file of
// load_dataparser_transform that is applied to cameras of other programs, or empty. points, up: of the scene, for the
// choice. placing: a motion of the scene from the file's coordinates that the cameras follow, at the end. bundle: the
// folder that the copies go to. Errors (exit code 3) name file and field.
UserViews read_user_views(const std::string& cameras, const std::string& folder, const std::string& dataparser,
                          const DataparserTransform& placing, const std::vector<Eigen::Vector3d>& points,
                          const std::string& up, const std::string& front, const std::string& bundle);

}  // namespace physmas::bundle

#endif
