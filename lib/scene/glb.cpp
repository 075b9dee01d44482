#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "records/json.h"
#include "scene/gaussian_files.h"

namespace physmas {
namespace {

// Values of glTF 2.0.
constexpr int kFloat = 5126, kUnsignedByte = 5121, kArrayBuffer = 34962, kPoints = 0;

// One vertex attribute: `count` floats of Gaussian i.
struct Attribute {
  std::string name;
  const char* type;
  int count;
  std::function<void(size_t i, float* out)> fill;
};

std::vector<Attribute> attributes_of(const Gaussians& g) {
  const auto with = [](const char* name) { return std::string("KHR_gaussian_splatting:") + name; };
  std::vector<Attribute> attributes;
  attributes.push_back(
      {"POSITION", "VEC3", 3, [&](size_t i, float* out) { std::copy_n(g.position[i].data(), 3, out); }});
  attributes.push_back({with("ROTATION"), "VEC4", 4, [&](size_t i, float* out) {
                          const std::array<float, 4>& q = g.rotation[i];
                          double norm = 0;
                          for (const float v : q) norm += double(v) * v;
                          for (int k = 0; k < 4; ++k) out[k] = static_cast<float>(q[(k + 1) % 4] / std::sqrt(norm));
                        }});
  attributes.push_back({with("SCALE"), "VEC3", 3, [&](size_t i, float* out) {
                          const Eigen::Vector3f scale = g.scale(i);
                          std::copy_n(scale.data(), 3, out);
                        }});
  attributes.push_back({with("OPACITY"), "SCALAR", 1, [&](size_t i, float* out) { *out = g.opacity(i); }});
  for (int degree = 0; degree <= g.sh_degree; ++degree) {
    for (int k = 0; k <= 2 * degree; ++k) {
      const int coefficient = degree * degree + k;
      attributes.push_back(
          {with("SH_DEGREE_") + fmt::format("{}_COEF_{}", degree, k), "VEC3", 3,
           [&g, coefficient](size_t i, float* out) { std::copy_n(g.sh_of(i)[coefficient].data(), 3, out); }});
    }
  }
  return attributes;
}

void put(std::string& bytes, uint32_t value) {
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(value >> 8 * k & 255);
}

}  // namespace

bool save_gaussians_glb(const std::string& path, const Gaussians& g) {
  Json views = Json::array(), accessors = Json::array(), names = Json::object();
  size_t size = 0;
  const auto describe = [&](const std::string& name, const char* type, int component, size_t each) {
    names[name] = accessors.size();
    views.push_back({{"buffer", 0}, {"byteOffset", size}, {"byteLength", each * g.size()}, {"target", kArrayBuffer}});
    accessors.push_back(
        {{"bufferView", views.size() - 1}, {"componentType", component}, {"count", g.size()}, {"type", type}});
    size += each * g.size();
  };
  const std::vector<Attribute> attributes = attributes_of(g);
  for (const Attribute& attribute : attributes)
    describe(attribute.name, attribute.type, kFloat, attribute.count * sizeof(float));
  // What viewers show that know of no splats.
  describe("COLOR_0", "VEC4", kUnsignedByte, 4);
  accessors.back()["normalized"] = true;
  Eigen::Vector3f low = g.position[0], high = low;
  for (const Eigen::Vector3f& p : g.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  accessors[0]["min"] = {low.x(), low.y(), low.z()};
  accessors[0]["max"] = {high.x(), high.y(), high.z()};
  const Json splats = {{"kernel", "ellipse"},
                       {"colorSpace", "srgb_rec709_display"},
                       {"projection", "perspective"},
                       {"sortingMethod", "zDepth"}};
  const Json primitive = {
      {"attributes", names}, {"mode", kPoints}, {"extensions", {{"KHR_gaussian_splatting", splats}}}};
  const Json document = {{"asset", {{"version", "2.0"}, {"generator", "PhysMAS"}}},
                         {"extensionsUsed", {"KHR_gaussian_splatting"}},
                         {"scene", 0},
                         {"scenes", {{{"nodes", {0}}}}},
                         {"nodes", {{{"mesh", 0}}}},
                         {"meshes", {{{"primitives", {primitive}}}}},
                         {"buffers", {{{"byteLength", size}}}},
                         {"bufferViews", views},
                         {"accessors", accessors}};
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const size_t whole = 12 + 8 + text.size() + 8 + size;
  if (whole > std::numeric_limits<uint32_t>::max())
    throw invalid_input({path, "", fmt::format("{} bytes", whole), "at most 4 GiB, as .glb files have"});
  std::string head = "glTF";
  put(head, 2);
  put(head, static_cast<uint32_t>(whole));
  put(head, static_cast<uint32_t>(text.size()));
  head += "JSON" + text;
  put(head, static_cast<uint32_t>(size));
  head += std::string("BIN\0", 4);
  FileWriter out(path);
  out.write(head);
  for (const Attribute& attribute : attributes) {
    float values[4];
    for (size_t i = 0; i < g.size(); ++i) {
      attribute.fill(i, values);
      out.write(values, attribute.count * sizeof(float));
    }
  }
  for (size_t i = 0; i < g.size(); ++i) {
    const Eigen::Vector3f color = g.base_color(i);
    uint8_t levels[4];
    for (int c = 0; c < 3; ++c) levels[c] = static_cast<uint8_t>(std::lround(255 * std::clamp(color[c], 0.0f, 1.0f)));
    levels[3] = static_cast<uint8_t>(std::lround(255 * g.opacity(i)));
    out.write(levels, 4);
  }
  return out.commit();
}

}  // namespace physmas
