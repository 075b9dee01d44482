// Reading and writing files of 3D Gaussians.
#ifndef PHYSMAS_SCENE_GAUSSIAN_FILES_H
#define PHYSMAS_SCENE_GAUSSIAN_FILES_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "records/state.h"
#include "scene/gaussians.h"

namespace physmas {

// What a file says of its Gaussians besides their values, and what reading it changed.
struct GaussianNotes {
  std::string up;                      // the scene axis that it says points up; empty when it says none
  Eigen::Vector3d offset = {0, 0, 0};  // was subtracted from all positions
  size_t dropped = 0;                  // Gaussians that no renderer draws
  std::vector<std::string> notes;      // sentences: what was followed
  std::vector<std::string> warnings;   // sentences: what may be wrong
};

struct GaussianFile {
  Gaussians gaussians;
  GaussianNotes notes;
};

struct ReadingOptions {
  bool drop_broken = false;    // also where more than one in a hundred Gaussians are such that no renderer draws them
  bool linear_scales = false;  // scales are standard deviations, not their logarithms
};

// Any file of Gaussians that is read: 3DGS and SuperSplat's compressed PLY, `.spz`, `.sog` or the folder of one,
// `.splat`; the first two also within gzip. Told apart by their first bytes, and `.splat`, which has none of its own,
// by its name. Every value of the result is finite (opacities apart) and every quaternion has a length; what the file
// says of itself is followed (its notes). A plain binary PLY is read piece by piece, and nothing else of it is held.
// Errors (exit code 3) name the file, the field or byte, what was found and expected; of the containers that are not
// read, which one it is and how to convert it.
GaussianFile read_gaussian_file(const std::string& path, const ReadingOptions& options = {});

// The same for bytes already in memory; `path` names them in messages and decides on `.splat`.
GaussianFile parse_gaussian_file(const std::string& path, const std::string& bytes, const ReadingOptions& options = {});

// The files that read_gaussian_file reads for `path`: itself, or those of a SOG folder.
std::vector<std::string> gaussian_input_files(const std::string& path);

// Gaussians of a file of ours: as read_gaussian_file, but every Gaussian must be one that is drawn.
Gaussians load_gaussians(const std::string& path);
Gaussians parse_gaussians(const std::string& path, const std::string& bytes);

// The Gaussians that `state` labels: as load_gaussians, and an Error when the file has another number of them.
// state_path: only named in that message.
Gaussians load_labelled_gaussians(const std::string& path, const State& state, const std::string& state_path);

// A standard 3DGS PLY as INRIA's code writes it: binary little endian, x y z nx ny nz f_dc_* f_rest_* opacity scale_*
// rot_*, float32, normals zero. Raw values are written bit for bit; a comment says where they are anti-aliased. Atomic;
// returns whether the file changed.
bool save_gaussians_ply(const std::string& path, const Gaussians& gaussians);

// The same in fewer bytes, each atomic, the values quantised as the format has it; returns whether the file changed.
// SuperSplat's compressed PLY: 16 bytes per Gaussian, and one for each coefficient of the higher harmonics; the
// Gaussians come in the order of a curve through space, so that those of a chunk lie together.
bool save_compressed_ply(const std::string& path, const Gaussians& gaussians);
// `.spz` of version 4. The scene must be turned so that y points up, as the format has it.
bool save_gaussians_spz(const std::string& path, const Gaussians& gaussians);

// One binary glTF file with KHR_gaussian_splatting: float32 throughout. The scene must be turned so that y points up.
// Atomic; returns whether the file changed.
bool save_gaussians_glb(const std::string& path, const Gaussians& gaussians);

}  // namespace physmas

#endif
