// Reading and writing files of 3D Gaussians.
#ifndef PHYSMAS_SCENE_GAUSSIAN_FILES_H
#define PHYSMAS_SCENE_GAUSSIAN_FILES_H

#include <string>

#include "records/state.h"
#include "scene/gaussians.h"

namespace physmas {

// Any supported file of Gaussians. PLY and `.spz` files are known by their first bytes, with SuperSplat's compressed
// PLY told apart by its elements; `.splat` files, which have no magic, by their name. Every value of the result is
// finite and every quaternion has a length. Errors (exit code 3) name the file, the field or byte, what was found and
// expected.
Gaussians load_gaussians(const std::string& path);

// The same for bytes already in memory; `path` names them in messages and decides on `.splat`.
Gaussians parse_gaussians(const std::string& path, const std::string& bytes);

// The Gaussians that `state` labels: as load_gaussians, and an Error when the file has another number of them.
// state_path: only named in that message.
Gaussians load_labelled_gaussians(const std::string& path, const State& state, const std::string& state_path);

// A standard 3DGS PLY as INRIA's code writes it: binary little endian, x y z nx ny nz f_dc_* f_rest_* opacity scale_*
// rot_*, float32, normals zero. Raw values are written bit for bit. Atomic; returns whether the file changed.
bool save_gaussians_ply(const std::string& path, const Gaussians& gaussians);

}  // namespace physmas

#endif
