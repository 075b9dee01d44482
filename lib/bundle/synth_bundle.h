// From a described scene to a bundle on disk.
#ifndef PHYSMAS_BUNDLE_SYNTH_BUNDLE_H
#define PHYSMAS_BUNDLE_SYNTH_BUNDLE_H

#include <string>

namespace physmas::bundle {

// Reads an example (records/example.h) and writes the bundle: gaussians.ply, views/NAME.png, inventory.json, truth.h5
// (/gaussians/row: the true row of every Gaussian) and, last, scene.json. Nothing is written when the example is wrong
// (exit code 3). Unchanged files keep their timestamps.
// masks: also write folder/true-masks/VIEW/OBJECT/PART.png, the pixels in which each true row weighs most, as
// pm-ground --perception masks:DIR reads them.
void write_synth_bundle(const std::string& example_path, const std::string& folder, bool masks = false);

}  // namespace physmas::bundle

#endif
