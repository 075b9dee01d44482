// From a user's own Gaussians to a bundle on disk.
#ifndef PHYSMAS_BUNDLE_IMPORT_BUNDLE_H
#define PHYSMAS_BUNDLE_IMPORT_BUNDLE_H

#include <string>

#include "bundle/selection.h"
#include "scene/gaussian_files.h"

namespace physmas::bundle {

struct ImportOptions {
  std::string gaussians;   // a file of read_gaussian_file, or the folder of a SOG scene
  ReadingOptions reading;  // how its values are taken
  std::string prompt;      // not blank
  std::string folder;      // of the bundle
  // Empty: what `physgaussian` says, else z in nerfstudio's frame, else what the file says, else -y.
  std::string up;
  std::string front;           // degrees or axis (front_degrees), a view's or image's name; empty: the usual
  std::string name;            // empty: made from the file's name
  std::string views;           // folder with the user's images, or empty
  std::string cameras;         // their cameras (user_views.h), with `views` only
  std::string dataparser;      // dataparser_transforms.json for `cameras`; empty: looked for; "none": without
  std::string inventory;       // authored inventory, or empty
  std::string masks;           // folder with VIEW/OBJECT.png and VIEW/OBJECT/PART.png, or empty
  std::string run;             // partial run specification, or empty
  std::string physgaussian;    // configuration that `run` and the other options win over, or empty
  std::string material_field;  // of another program (material_files.h), or empty
  Selection selection;         // which Gaussians are taken
  double drop = 0.15;          // height of the lowest mean above the floor that is added, solver units, >= 0
  double view_elevation = 10;  // of the four views that we render, degrees
  double azimuth = 25;         // of the output camera, degrees from the front towards the right
  double elevation = 15;       // of the output camera, degrees
};

// Reads and checks everything, then writes the bundle: gaussians.ply, views, the authored files and, last, scene.json.
// Without colliders in the run specification a floor is added below the scene; without a placement there, the scene
// stands so low that the floor lies a little above the lower wall. Errors (exit code 3): what the readers refuse, a
// blank prompt, not exactly four views, an image of another size than its camera, a scene or floor outside the walls.
// A PhysGaussian configuration also leaves material-records.json, hints for pm-material --authored; what could not be
// mapped is printed and recorded in the provenance of scene.json. A material field becomes material-field.h5, moved and
// turned as the Gaussians are; one that lies elsewhere is refused. Unchanged files keep their timestamps.
void write_import_bundle(const ImportOptions& options);

}  // namespace physmas::bundle

#endif
