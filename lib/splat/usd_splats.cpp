#include "splat/usd_splats.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace physmas::splat {
namespace {

constexpr float kExtent = 3;  // standard deviations

template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

uint16_t half_of(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  const auto sign = static_cast<uint16_t>(bits >> 16 & 0x8000);
  const double size = std::abs(static_cast<double>(value));
  if (!(size < 65520)) return sign | 0x7bff;
  if (size < 6.103515625e-05) return sign | static_cast<uint16_t>(std::lrint(std::ldexp(size, 24)));
  int exponent = 0;
  const double fraction = std::frexp(size, &exponent);  // 0.5 to below 1
  // A fraction that rounds up to 2048 carries into the exponent, as it should.
  const long rounded = std::lrint(std::ldexp(fraction, 11)) - 1024;
  return sign | static_cast<uint16_t>(((exponent + 14) << 10) + rounded);
}

UsdSplats::UsdSplats(const std::string& path, const std::string& up, double fps) : crate_(path), up_(up), fps_(fps) {}

void UsdSplats::sample(Track& track, int frame, UsdType type, std::string bytes, size_t count) {
  track.times.push_back(frame);
  if (!track.values.empty() && bytes == track.last) {
    track.values.push_back(track.values.back());
    return;
  }
  track.values.push_back(crate_.array(type, bytes.data(), count, bytes.size() / std::max<size_t>(1, count)));
  track.last = std::move(bytes);
}

void UsdSplats::add(int frame, const Gaussians& g) {
  if (last_ < first_) first_ = frame, degree_ = g.sh_degree;
  last_ = frame;
  const size_t n = g.size();
  std::string positions, orientations, scales, harmonics, extent;
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (size_t i = 0; i < n; ++i) {
    put(positions, g.position[i]);
    const Eigen::Vector3f scale = g.scale(i);
    put(scales, scale);
    // In memory the real part comes last.
    const std::array<float, 4>& q = g.rotation[i];
    const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (const int c : {1, 2, 3, 0}) put(orientations, half_of(q[c] / norm));
    const Eigen::Array3f reach = kExtent * (g.rotation_matrix(i) * scale.asDiagonal()).rowwise().norm().array();
    low = low.min(g.position[i].array() - reach);
    high = high.max(g.position[i].array() + reach);
  }
  for (const Eigen::Vector3f& c : g.sh) {
    for (int k = 0; k < 3; ++k) put(harmonics, half_of(c[k]));
  }
  put(extent, low);
  put(extent, high);
  sample(positions_, frame, UsdType::vec3f, std::move(positions), n);
  sample(orientations_, frame, UsdType::quath, std::move(orientations), n);
  sample(scales_, frame, UsdType::vec3f, std::move(scales), n);
  sample(harmonics_, frame, UsdType::vec3h, std::move(harmonics), g.sh.size());
  sample(extent_, frame, UsdType::vec3f, std::move(extent), 2);
  if (opacities_.values.empty()) {
    std::string opacities;
    for (size_t i = 0; i < n; ++i) put(opacities, g.opacity(i));
    sample(opacities_, frame, UsdType::float_, std::move(opacities), n);
  }
}

void UsdSplats::attribute(const std::string& prim, const char* name, const char* type, const Track& track) {
  const bool still = std::all_of(track.values.begin(), track.values.end(),
                                 [&](UsdValue value) { return value == track.values.front(); });
  if (still) {
    crate_.add_attribute(prim, name, type, false, "default", track.values.front());
  } else {
    crate_.add_attribute(prim, name, type, false, "timeSamples", crate_.samples(track.times, track.values));
  }
}

bool UsdSplats::commit() {
  crate_.set_metadata("defaultPrim", crate_.token("Scene"));
  crate_.set_metadata("upAxis", crate_.token(up_ == "z" ? "Z" : "Y"));
  crate_.set_metadata("metersPerUnit", crate_.real(1));
  crate_.set_metadata("timeCodesPerSecond", crate_.real(fps_));
  crate_.set_metadata("framesPerSecond", crate_.real(fps_));
  crate_.set_metadata("startTimeCode", crate_.real(first_));
  crate_.set_metadata("endTimeCode", crate_.real(last_));
  crate_.set_metadata("documentation", crate_.string("Written by PhysMAS"));
  const std::string scene = crate_.add_prim("", "Scene", "Xform");
  const std::string splats = crate_.add_prim(scene, "Splats", "ParticleField3DGaussianSplat");
  attribute(splats, "extent", "float3[]", extent_);
  attribute(splats, "positions", "point3f[]", positions_);
  attribute(splats, "orientationsh", "quath[]", orientations_);
  attribute(splats, "scales", "float3[]", scales_);
  attribute(splats, "opacities", "float[]", opacities_);
  attribute(splats, "radiance:sphericalHarmonicsCoefficientsh", "half3[]", harmonics_);
  crate_.add_attribute(splats, "radiance:sphericalHarmonicsDegree", "int", true, "default", crate_.integer(degree_));
  crate_.add_attribute(splats, "projectionModeHint", "token", true, "default", crate_.token("perspective"));
  crate_.add_attribute(splats, "sortingModeHint", "token", true, "default", crate_.token("zDepth"));
  return crate_.commit();
}

}  // namespace physmas::splat
