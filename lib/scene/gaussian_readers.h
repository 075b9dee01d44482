// The readers behind read_gaussian_file, one per layout. They fill in values and notes; checking values is shared.
#ifndef PHYSMAS_SCENE_GAUSSIAN_READERS_H
#define PHYSMAS_SCENE_GAUSSIAN_READERS_H

#include <functional>
#include <string>

#include "scene/gaussian_files.h"
#include "scene/gaussians.h"
#include "scene/ply_file.h"

namespace physmas {

// The natural logarithm that stands for a scale of 0: a flat Gaussian.
constexpr float kFlatLogScale = -87.3365f;

// Large captured scenes reach a few GiB.
constexpr size_t kMaxGaussianBytes = size_t{16} << 30;

// Standard 3DGS PLY (Kerbl et al. 2023): element vertex with x y z, f_dc_0..2, f_rest_* channel-major (0, 9, 24, 45 or
// 72 of them, of which degree 4 is left out), opacity, scale_0..2 (or 0..1: 2D Gaussians), rot_0..3, in any order and
// scalar type; filter_3D (Mip-Splatting) is folded into scales and opacity; everything else is ignored. Positions in
// doubles that floats would round too much have their offset subtracted first, and z up.
Gaussians read_standard_ply(const PlyFile& file, GaussianNotes& notes);

// What the comments of a PLY say: the vertical axis, anti-aliasing.
void follow_comments(const PlyFile& file, Gaussians& gaussians, GaussianNotes& notes);

// Whether the file has SuperSplat's compressed layout, and its reader (PlayCanvas compressed PLY): chunks of 256
// Gaussians with bounds, packed vertices, optional 8-bit spherical harmonics.
bool is_compressed_ply(const PlyFile& file);
Gaussians read_compressed_ply(const PlyFile& file);

// `.splat` (antimatter15): 32 bytes per Gaussian: position and linear scale as float32, RGBA and quaternion as bytes.
Gaussians read_splat(const std::string& path, const std::string& bytes);

// Whether the bytes start as an .spz file of version 4 does. Those of versions 1 to 3 lie within gzip.
bool is_spz(const std::string& bytes);

// `.spz` (Niantic Labs). Version 4: a header, a table of contents and one zstd stream per attribute; versions 1 to 3,
// from the bytes that were within gzip: a header of 16 bytes and one array per attribute. Means of 24-bit fixed point
// or halves (version 1), 8-bit opacities, colours, log scales and harmonics, quaternions of 3 or 4 bytes. Degree 4 is
// left out, and said. Values are taken as stored: right, up, back, so y points up, unless the file says another
// coordinate system; left-handed ones are mirrored. Nothing is allocated that the compressed size could not hold.
// packed: size of the file around them; 0: none.
constexpr size_t kSpzHeaderBytes = 16;
// Of SPZ: how coefficient 0 of a colour is scaled to a byte, and the bit of its flags for anti-aliased files.
constexpr double kSpzColorScale = 0.15;
constexpr uint8_t kSpzAntialiased = 1;
Gaussians read_spz(const std::string& path, const std::string& bytes, size_t packed, GaussianNotes& notes);

// The most bytes that are taken of a file within gzip. header: its first kSpzHeaderBytes bytes, or fewer.
size_t spz_bytes(const std::string& path, const std::string& header, size_t packed);

// SOG of version 2 (PlayCanvas): meta.json and lossless images. read: the bytes of a file by its name in meta.json,
// size: of all of them together, which bounds the number of Gaussians.
using SogFiles = std::function<std::string(const std::string& name)>;
Gaussians read_sog(const std::string& path, const SogFiles& read, uint64_t size, GaussianNotes& notes);

// The error for bytes that none of the readers knows: which container it is and how to convert it.
Error unread_container(const std::string& path, const std::string& bytes);
// The same for a ZIP archive that is no SOG, and for a folder. names: of what is in it.
Error unread_archive(const std::string& path, const std::vector<std::string>& names);
Error unread_folder(const std::string& path, const std::vector<std::string>& names);

// Logit of an opacity in 0..1. 0 and 1 stay finite: they are moved inwards by 1e-6, far below what is visible.
float opacity_logit_of(double opacity);

// Coefficient of the constant spherical harmonic for a colour in 0..1.
float sh_of_color(double color);

// Turns z around: a left-handed scene becomes a right-handed one.
void mirror_z(Gaussians& gaussians);

// Scales of minus infinity become flat. Gaussians with another value that is not finite or a quaternion without length
// are removed and counted; one in a hundred of them, or any with `strict`, are an Error that names the first.
// unit: what the file calls a Gaussian ("element vertex row", "Gaussian").
void sweep_values(const std::string& path, const std::string& unit, const ReadingOptions& options, bool strict,
                  GaussianFile& file);

}  // namespace physmas

#endif
