// Containers that hold Gaussians, or that people take for such, and that are not read.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "base/words.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr const char* kExpected = "a 3DGS .ply, a SuperSplat .compressed.ply, an .spz, a .sog, or a .splat file";
constexpr const char* kTrain =
    "a trained splat is needed: make one from photographs with nerfstudio (splatfacto), gsplat, Brush or Postshot, and "
    "import the .ply that it exports";
constexpr const char* kConvert = "convert it to .ply, for example with splat-transform or SuperSplat";
constexpr const char* kExport = "export a .ply with the program that made it";

struct Container {
  const char* start;   // of the bytes; empty: any
  size_t length;       // of `start`
  const char* ending;  // of the name, lower case; empty: any
  const char* what;
  const char* fix;
};

#define PHYSMAS_START(text) text, sizeof(text) - 1

// The first that fits counts.
const Container kContainers[] = {
    {PHYSMAS_START("\xff\xd8\xff"), "", "a photograph (JPEG)", kTrain},
    {PHYSMAS_START("\x89PNG"), "", "a photograph (PNG)", kTrain},
    {PHYSMAS_START(""), ".heic", "a photograph (HEIC)", kTrain},
    {PHYSMAS_START("RIFF"), ".webp", "a photograph (WebP)", kTrain},
    {PHYSMAS_START(""), ".mp4", "a video", kTrain},
    {PHYSMAS_START(""), ".mov", "a video", kTrain},
    {PHYSMAS_START("glTF"), "", "a glTF file", kConvert},
    {PHYSMAS_START(""), ".gltf", "a glTF file", kConvert},
    {PHYSMAS_START("PXR-USDC"), "", "a USD file", kExport},
    {PHYSMAS_START("#usda"), "", "a USD file", kExport},
    {PHYSMAS_START(""), ".usdz", "a USD archive", kExport},
    {PHYSMAS_START("\x89HDF"), "", "an HDF5 file", kExport},
    {PHYSMAS_START("version https://git-lfs"), "", "a pointer of Git LFS in place of the file", "run git lfs pull"},
    {PHYSMAS_START("<!DOCTYPE"), "", "a web page", "download the file itself"},
    {PHYSMAS_START("<html"), "", "a web page", "download the file itself"},
    {PHYSMAS_START(""), ".ksplat", "a .ksplat file (GaussianSplats3D)", kConvert},
    {PHYSMAS_START(""), ".lcc", "an .lcc file (XGRIDS)", kConvert},
    {PHYSMAS_START(""), ".lcc2", "an .lcc2 file (XGRIDS)", kConvert},
    {PHYSMAS_START(""), ".rad", "a .rad file (Spark)", kConvert},
    {PHYSMAS_START(""), ".splatv", "a .splatv file", kConvert},
    {PHYSMAS_START(""), ".ckpt", "a checkpoint of a training", kExport},
    {PHYSMAS_START(""), ".pth", "a checkpoint of a training", kExport},
    {PHYSMAS_START(""), ".pt", "a checkpoint of a training", kExport},
    {PHYSMAS_START("\x93NUMPY"), "", "a numpy array", kExport},
    {PHYSMAS_START("LASF"), "", "a LAS point cloud", "a plain point cloud has no Gaussians"},
    {PHYSMAS_START("ASTM-E57"), "", "an E57 point cloud", "a plain point cloud has no Gaussians"},
    {PHYSMAS_START(""), ".obj", "a mesh", "a mesh has no Gaussians"},
    {PHYSMAS_START(""), ".stl", "a mesh", "a mesh has no Gaussians"},
    {PHYSMAS_START(""), ".fbx", "a mesh", "a mesh has no Gaussians"},
};

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

Error unread_container(const std::string& path, const std::string& bytes) {
  const std::string name = lower_case(path);
  for (const Container& c : kContainers) {
    if (bytes.compare(0, c.length, c.start, c.length) == 0 && ends_with(name, c.ending))
      return invalid_input({path, "byte 0", c.what, kExpected, c.fix});
  }
  return invalid_input({path, "byte 0", bytes.empty() ? "an empty file" : "no PLY magic", kExpected});
}

namespace {

// The first of the names with one of the endings; empty: none.
std::string first_with(const std::vector<std::string>& names, std::initializer_list<const char*> endings) {
  for (const char* ending : endings) {
    for (const std::string& name : names) {
      if (ends_with(lower_case(name), ending)) return one_line(name, 120);
    }
  }
  return "";
}

std::string splat_among(const std::vector<std::string>& names) {
  return first_with(names, {".ply", ".spz", ".splat", ".sog", ".gz"});
}

std::string picture_among(const std::vector<std::string>& names) {
  return first_with(names, {".jpg", ".jpeg", ".png", ".heic", ".webp"});
}

}  // namespace

Error unread_archive(const std::string& path, const std::vector<std::string>& names) {
  const auto refused = [&](const std::string& what, const char* fix) {
    return invalid_input({path, "", what, kExpected, fix});
  };
  const std::string splat = splat_among(names);
  if (!splat.empty()) return refused("a ZIP archive that holds " + splat, "unpack the archive and import that file");
  if (!first_with(names, {"data.pkl"}).empty()) return refused("a checkpoint of PyTorch", kExport);
  if (!first_with(names, {".npy"}).empty()) return refused("an archive of numpy arrays", kExport);
  if (!first_with(names, {".usdc", ".usda"}).empty()) return refused("a USD archive", kExport);
  if (!picture_among(names).empty()) return refused("a ZIP archive of pictures", kTrain);
  return refused("a ZIP archive without meta.json", "one with it is a SOG scene");
}

Error unread_folder(const std::string& path, const std::vector<std::string>& names) {
  const std::string splat = splat_among(names);
  if (!splat.empty()) return invalid_input({path, "", "a folder that holds " + splat, kExpected, "import that file"});
  if (!picture_among(names).empty()) return invalid_input({path, "", "a folder of pictures", kExpected, kTrain});
  return invalid_input(
      {path, "", "a folder without meta.json", std::string(kExpected) + "; a folder with it is a SOG scene"});
}

}  // namespace physmas
