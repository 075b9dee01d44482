// The readers behind load_gaussians, one per layout. They fill in values; checking them is shared.
#ifndef PHYSMAS_SCENE_GAUSSIAN_READERS_H
#define PHYSMAS_SCENE_GAUSSIAN_READERS_H

#include <string>

#include "scene/gaussians.h"
#include "scene/ply_file.h"

namespace physmas {

// Standard 3DGS PLY (Kerbl et al. 2023): element vertex with x y z, f_dc_0..2, f_rest_* channel-major (0, 9, 24 or 45
// of them), opacity, scale_0..2, rot_0..3, in any order and scalar type; everything else is ignored.
Gaussians read_standard_ply(const PlyFile& file);

// Whether the file has SuperSplat's compressed layout, and its reader (PlayCanvas compressed PLY): chunks of 256
// Gaussians with bounds, packed vertices, optional 8-bit spherical harmonics.
bool is_compressed_ply(const PlyFile& file);
Gaussians read_compressed_ply(const PlyFile& file);

// `.splat` (antimatter15): 32 bytes per Gaussian: position and linear scale as float32, RGBA and quaternion as bytes.
Gaussians read_splat(const std::string& path, const std::string& bytes);

// Whether the bytes start as a gzip stream or as an uncompressed .spz file do.
bool is_spz(const std::string& bytes);

// `.spz` (Niantic Labs), versions 2 and 3: a gzip stream of a 16-byte header and one array per attribute: 24-bit
// fixed-point means, 8-bit opacities, colours, log scales and harmonics, quaternions of 3 or 4 bytes. Values are taken
// as stored: right, up, back, so y points up. Nothing is allocated that the compressed size could not hold.
Gaussians read_spz(const std::string& path, const std::string& bytes);

// Logit of an 8-bit opacity. 0 and 255 stay finite: they are moved inwards by 1e-6, far below what is visible.
float opacity_logit_of_byte(double byte);

// Coefficient of the constant spherical harmonic for a colour in 0..1.
float sh_of_color(double color);

// Throws an Error that names the first Gaussian with a value that is not finite or a quaternion without length.
// unit: what the file calls a Gaussian ("element vertex row", "Gaussian").
void check_values(const std::string& path, const std::string& unit, const Gaussians& gaussians);

}  // namespace physmas

#endif
