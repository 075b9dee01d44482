// The scene bundle: scene.json, or the slice of it that one stage depends on.
#ifndef PHYSMAS_RECORDS_SCENE_H
#define PHYSMAS_RECORDS_SCENE_H

#include <map>
#include <string>
#include <vector>

#include "records/camera.h"
#include "records/json_fwd.h"
#include "records/provenance.h"
#include "records/run_specification.h"

namespace physmas {

// One of the four calibrated views. `image` is a path that can be opened.
struct SceneView {
  std::string name;
  std::string image;
  Camera camera;
};

// Paths are resolved: they can be opened as they are. Empty where the file (a slice) does not have them.
struct Scene {
  std::string file;   // the scene.json or slice that was read
  std::string root;   // the bundle's folder
  std::string slice;  // stage name, empty for a whole scene
  std::string name;
  std::string prompt;
  std::string gaussians;
  std::vector<SceneView> views;  // four, or none in a slice that needs none
  std::vector<Camera> output_cameras;
  std::string inventory;       // authored, or empty
  std::string masks;           // authored masks folder, or empty
  std::string materials;       // material records that came with the file (a PhysGaussian configuration), or empty
  std::string material_field;  // material-field.h5 (records/material_field.h), or empty
  RunSpecification run;

  // The camera of output frame t: cameras are one for all frames, or one per frame.
  const Camera& output_camera(int t) const {
    return output_cameras.size() == 1 ? output_cameras[0] : output_cameras.at(t);
  }
};

// What a stage cannot do without; a missing part is an Error (exit code 3) that names the field.
struct SceneNeeds {
  bool prompt = false;
  bool gaussians = false;
  bool views = false;
  bool output_cameras = false;
};

// A motion prompt: at most this many characters of UTF-8, not all blank. source: where it stands ("--prompt" or a file)
// for the Error (exit code 3).
constexpr long kMaxPrompt = 2000;
void check_prompt(const std::string& prompt, const std::string& source);

// Reads and validates scene.json or a slice. All paths must stay inside the bundle's folder. Files that a slice
// lists with their SHA-256 must still have it.
Scene load_scene(const std::string& path, const SceneNeeds& needs);

// Writes scene.json. `scene` paths must lie inside the folder of `path`. Views must be four (or none were asked for:
// never), output cameras one or T.
void save_scene(const std::string& path, const Scene& scene, const Provenance& provenance);

// The run specification of a scene's document, which holds it or names its file; an empty object where it has none.
// path, root: the document's file, and the bundle's folder.
Json resolve_run(const Json& document, const std::string& path, const std::string& root);

}  // namespace physmas

#endif
