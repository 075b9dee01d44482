#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "scene/gaussian_files.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

int required_property(const PlyFile& file, const PlyElement& vertex, const std::string& name) {
  const int index = vertex.find(name);
  if (index < 0) {
    throw invalid_input({file.path(), "element vertex", "no property " + name, "the properties of a 3DGS file",
                         "a plain point cloud or mesh has no Gaussians"});
  }
  return index;
}

constexpr double kThinner = 1000;   // the third scale of a 2D Gaussian is so much smaller than the others
constexpr double kFar = 1e3;        // from the origin: offsets of maps, not of captures
constexpr double kRounding = 1e-5;  // of the scene's size: what floats may move positions by

// Degree of the harmonics in the file, 4 included.
int stored_degree(const PlyFile& file, const PlyElement& vertex) {
  const auto is_rest = [](const PlyProperty& p) {
    return p.name.rfind("f_rest_", 0) == 0 && p.name.size() > 7 && std::isdigit(static_cast<unsigned char>(p.name[7]));
  };
  const auto count = std::count_if(vertex.properties.begin(), vertex.properties.end(), is_rest);
  for (int degree = 0; degree <= 4; ++degree) {
    if (count == 3 * (sh_coefficient_count(degree) - 1)) return degree;
  }
  throw invalid_input(
      {file.path(), "element vertex", fmt::format("{} f_rest_* properties", count), "0, 9, 24, 45 or 72"});
}

// Names of the three base colours: harmonics, or 8-bit sRGB (nerfstudio's `--ply-color-mode rgb`).
std::array<const char*, 3> color_names(const PlyElement& vertex) {
  const std::array<const char*, 3> levels = {"red", "green", "blue"};
  const bool has_levels = std::all_of(levels.begin(), levels.end(), [&](const char* name) {
    const int index = vertex.find(name);
    return index >= 0 && vertex.properties[index].type == PlyType::uint8;
  });
  if (vertex.find("f_dc_0") < 0 && has_levels) return levels;
  return {"f_dc_0", "f_dc_1", "f_dc_2"};
}

// What positions in doubles must lose before they are floats: the middle of their box, to whole units. Zero where
// floats hold them well enough.
Eigen::Vector3d offset_of(const PlyFile& file, const PlyElement& vertex, const std::vector<int>& xyz) {
  const auto is_double = [&](int p) { return vertex.properties[p].type == PlyType::float64; };
  if (!std::all_of(xyz.begin(), xyz.end(), is_double)) return {0, 0, 0};
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::max()), high = -low;
  file.read_rows(vertex, xyz, [&](size_t, const double* v) {
    if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) return;
    const Eigen::Array3d p(v[0], v[1], v[2]);
    low = low.min(p);
    high = high.max(p);
  });
  const double size = (high - low).maxCoeff(), farthest = std::max(low.abs().maxCoeff(), high.abs().maxCoeff());
  const double rounding = farthest * std::numeric_limits<float>::epsilon();
  if (!(size >= 0) || !(farthest > kFar) || !(rounding > kRounding * size)) return {0, 0, 0};
  return (0.5 * (low + high)).round();
}

// Mip-Splatting's filter of a Gaussian, as its authors fold it into an exported file: variances add up, and the opacity
// shrinks as the volume grows.
void fold_filter(double filter, Gaussians& g, size_t i) {
  double shrunk = 1;
  for (int a = 0; a < 3; ++a) {
    const double variance = std::exp(2.0 * g.log_scale[i][a]), wider = variance + filter * filter;
    shrunk *= wider > 0 ? variance / wider : 1;
    g.log_scale[i][a] = static_cast<float>(0.5 * std::log(wider));
  }
  const double opacity = 1 / (1 + std::exp(-static_cast<double>(g.opacity_logit[i])));
  g.opacity_logit[i] = opacity_logit_of(opacity * std::sqrt(shrunk));
}

// A program's file of Gaussians that are not there before its networks have run.
void refuse_anchors(const PlyFile& file, const PlyElement& vertex) {
  if (vertex.find("f_offset_0") < 0 && vertex.find("f_anchor_feat_0") < 0) return;
  throw invalid_input({file.path(), "element vertex", "anchors of Scaffold-GS, whose networks make the Gaussians",
                       "the properties of a 3DGS file",
                       "export plain Gaussians with the program that trained it, or train with another method"});
}

}  // namespace

Gaussians read_standard_ply(const PlyFile& file, GaussianNotes& notes) {
  const PlyElement* vertex = file.find("vertex");
  if (vertex == nullptr) throw invalid_input({file.path(), "header", "no element vertex", "one row per Gaussian"});
  refuse_anchors(file, *vertex);
  const bool flat = vertex->find("scale_0") >= 0 && vertex->find("scale_1") >= 0 && vertex->find("scale_2") < 0;
  const int third = flat ? 1 : 2;
  const int filter = vertex->find("filter_3D");
  std::vector<std::string> names = {"x",     "y",     "z",     "scale_0", "scale_1", fmt::format("scale_{}", third),
                                    "rot_0", "rot_1", "rot_2", "rot_3"};
  const std::array<const char*, 3> colors = color_names(*vertex);
  const bool levels = std::string(colors[0]) == "red";
  names.push_back("opacity");
  names.insert(names.end(), colors.begin(), colors.end());
  const int stored = stored_degree(file, *vertex), degree = std::min(stored, 3);
  const int rest = sh_coefficient_count(degree) - 1, stored_rest = sh_coefficient_count(stored) - 1;  // per channel
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < rest; ++k) names.push_back(fmt::format("f_rest_{}", c * stored_rest + k));
  }
  std::vector<int> wanted;
  for (const std::string& name : names) wanted.push_back(required_property(file, *vertex, name));
  if (filter >= 0) wanted.push_back(filter);
  for (const PlyProperty& property : vertex->properties) {
    if (property.is_list) {
      throw invalid_input({file.path(), "element vertex property " + property.name, "a list", "plain numbers"});
    }
  }
  if (vertex->count == 0) throw invalid_input({file.path(), "element vertex", "no Gaussians", "at least one"});
  const Eigen::Vector3d offset = offset_of(file, *vertex, {wanted[0], wanted[1], wanted[2]});

  Gaussians g;
  g.resize(vertex->count, degree);
  file.read_rows(*vertex, wanted, [&](size_t i, const double* v) {
    const auto at = [v](int k) { return static_cast<float>(v[k]); };
    g.position[i] = (Eigen::Vector3d(v[0], v[1], v[2]) - offset).cast<float>();
    g.log_scale[i] = {at(3), at(4), at(5)};
    if (flat) g.log_scale[i][2] = std::min(at(3), at(4)) - static_cast<float>(std::log(kThinner));
    g.rotation[i] = {at(6), at(7), at(8), at(9)};
    g.opacity_logit[i] = at(10);
    Eigen::Vector3f* sh = &g.sh[i * (rest + 1)];
    for (int c = 0; c < 3; ++c) sh[0][c] = levels ? sh_of_color(v[11 + c] / 255) : at(11 + c);
    for (int k = 0; k < rest; ++k) sh[k + 1] = {at(14 + k), at(14 + rest + k), at(14 + 2 * rest + k)};
    if (filter >= 0) fold_filter(v[wanted.size() - 1], g, i);
  });
  notes.offset = offset;
  if (!offset.isZero()) {
    notes.up = "z";
    notes.notes.push_back(fmt::format(
        "({}, {}, {}) was subtracted from all positions, which floats would round; as on maps, z is taken as "
        "up; --up says otherwise",
        offset.x(), offset.y(), offset.z()));
  }
  if (flat) notes.notes.push_back("2D Gaussians: read as flat ones");
  if (stored > 3) notes.notes.push_back("harmonics of degree 4 are left out: degrees 0 to 3 are drawn");
  if (filter >= 0) {
    g.antialiased = true;
    notes.notes.push_back("trained with Mip-Splatting: its filter is folded into scales and opacities");
  }
  return g;
}

bool save_gaussians_ply(const std::string& path, const Gaussians& g) {
  const int rest = sh_coefficient_count(g.sh_degree) - 1;
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  if (g.antialiased) bytes += "comment SplatRenderMode: mip\n";
  bytes += fmt::format("element vertex {}\n", g.size());
  int columns = 0;
  const auto declare = [&](const std::string& name) {
    bytes += "property float " + name + "\n";
    ++columns;
  };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) declare(name);
  for (int i = 0; i < 3 * rest; ++i) declare(fmt::format("f_rest_{}", i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    declare(name);
  }
  bytes += "end_header\n";

  FileWriter out(path);
  out.write(bytes);
  std::vector<float> row(columns, 0.0f);
  for (size_t i = 0; i < g.size(); ++i) {
    const Eigen::Vector3f* sh = g.sh_of(i);
    float* at = row.data();
    for (int a = 0; a < 3; ++a) *at++ = g.position[i][a];
    at += 3;  // normals stay zero
    for (int c = 0; c < 3; ++c) *at++ = sh[0][c];
    for (int c = 0; c < 3; ++c) {
      for (int k = 1; k <= rest; ++k) *at++ = sh[k][c];
    }
    *at++ = g.opacity_logit[i];
    for (int a = 0; a < 3; ++a) *at++ = g.log_scale[i][a];
    for (float q : g.rotation[i]) *at++ = q;
    out.write(row.data(), row.size() * sizeof(float));
  }
  return out.commit();
}

}  // namespace physmas
