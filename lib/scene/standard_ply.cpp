#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

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

int sh_degree_of(const PlyFile& file, const PlyElement& vertex) {
  const auto is_rest = [](const PlyProperty& p) {
    return p.name.rfind("f_rest_", 0) == 0 && p.name.size() > 7 && std::isdigit(static_cast<unsigned char>(p.name[7]));
  };
  const auto count = std::count_if(vertex.properties.begin(), vertex.properties.end(), is_rest);
  for (int degree = 0; degree <= 3; ++degree) {
    if (count == 3 * (sh_coefficient_count(degree) - 1)) return degree;
  }
  throw invalid_input({file.path(), "element vertex", fmt::format("{} f_rest_* properties", count), "0, 9, 24 or 45"});
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

}  // namespace

Gaussians read_standard_ply(const PlyFile& file) {
  const PlyElement* vertex = file.find("vertex");
  if (vertex == nullptr) throw invalid_input({file.path(), "header", "no element vertex", "one row per Gaussian"});
  std::vector<std::string> names = {"x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"};
  const std::array<const char*, 3> colors = color_names(*vertex);
  const bool levels = std::string(colors[0]) == "red";
  names.push_back("opacity");
  names.insert(names.end(), colors.begin(), colors.end());
  const int degree = sh_degree_of(file, *vertex);
  const int rest = sh_coefficient_count(degree) - 1;  // per channel
  for (int i = 0; i < 3 * rest; ++i) names.push_back(fmt::format("f_rest_{}", i));
  std::vector<int> wanted;
  for (const std::string& name : names) wanted.push_back(required_property(file, *vertex, name));
  for (const PlyProperty& property : vertex->properties) {
    if (property.is_list) {
      throw invalid_input({file.path(), "element vertex property " + property.name, "a list", "plain numbers"});
    }
  }
  if (vertex->count == 0) throw invalid_input({file.path(), "element vertex", "no Gaussians", "at least one"});

  Gaussians g;
  g.resize(vertex->count, degree);
  file.read_rows(*vertex, wanted, [&](size_t i, const double* v) {
    const auto at = [v](int k) { return static_cast<float>(v[k]); };
    g.position[i] = {at(0), at(1), at(2)};
    g.log_scale[i] = {at(3), at(4), at(5)};
    g.rotation[i] = {at(6), at(7), at(8), at(9)};
    g.opacity_logit[i] = at(10);
    Eigen::Vector3f* sh = &g.sh[i * (rest + 1)];
    for (int c = 0; c < 3; ++c) sh[0][c] = levels ? sh_of_color(v[11 + c] / 255) : at(11 + c);
    for (int k = 0; k < rest; ++k) sh[k + 1] = {at(14 + k), at(14 + rest + k), at(14 + 2 * rest + k)};
  });
  return g;
}

bool save_gaussians_ply(const std::string& path, const Gaussians& g) {
  const int rest = sh_coefficient_count(g.sh_degree) - 1;
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
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

  bytes.reserve(bytes.size() + g.size() * columns * sizeof(float));
  std::vector<float> row(columns, 0.0f);
  for (size_t i = 0; i < g.size(); ++i) {
    const Eigen::Vector3f* sh = g.sh_of(i);
    float* out = row.data();
    for (int a = 0; a < 3; ++a) *out++ = g.position[i][a];
    out += 3;  // normals stay zero
    for (int c = 0; c < 3; ++c) *out++ = sh[0][c];
    for (int c = 0; c < 3; ++c) {
      for (int k = 1; k <= rest; ++k) *out++ = sh[k][c];
    }
    *out++ = g.opacity_logit[i];
    for (int a = 0; a < 3; ++a) *out++ = g.log_scale[i][a];
    for (float q : g.rotation[i]) *out++ = q;
    bytes.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float));
  }
  return write_file(path, bytes);
}

}  // namespace physmas
