#include <doctest/doctest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>

#include "scene/gaussian_files.h"
#include "unit/input_error.h"
#include "unit/scene/spz_bytes.h"

using namespace physmas;
using namespace physmas::testing;

namespace {

std::string error_of(const std::string& bytes) {
  return message_of([&] { parse_gaussians("a.spz", bytes); });
}

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("spz: version 2 decodes by the format's rules") {
  SpzGaussian a;
  a.position = {-4096, 6144, 8388607};  // with 12 fractional bits: -1, 1.5 and the largest
  a.opacity = 51;
  a.color = {255, 0, 128};
  a.scale = {0, 160, 255};
  a.rotation = {255, 0, 0, 0};  // x = 1, y = z = -1: longer than 1, so w = 0
  const Gaussians g = parse_gaussians("a.spz", gzip(spz_body(2, 0, {a}, 12)));
  REQUIRE(g.size() == 1);
  CHECK(g.sh_degree == 0);
  CHECK(g.position[0] == Eigen::Vector3f(-1, 1.5f, 8388607 / 4096.0f));
  CHECK(g.opacity(0) == doctest::Approx(0.2));
  CHECK(g.sh[0].x() == doctest::Approx(0.5 / 0.15));
  CHECK(g.sh[0].y() == doctest::Approx(-0.5 / 0.15));
  CHECK(g.sh[0].z() == doctest::Approx((128 / 255.0 - 0.5) / 0.15));
  CHECK(g.log_scale[0] == Eigen::Vector3f(-10, 0, 5.9375f));
  CHECK(g.rotation[0] == std::array<float, 4>{0, 1, -1, -1});
}

TEST_CASE("spz: version 3 keeps the three smaller parts of a quaternion with sign and nine bits") {
  SpzGaussian a;
  // w is left out (3); x = +511, y = -256, z = +0 of 511 / sqrt(2).
  const uint32_t word = 3u << 30 | 511u << 20 | (0x200u | 256u) << 10 | 0u;
  std::memcpy(a.rotation.data(), &word, 4);
  SpzGaussian b;  // x is left out; the others are y, z, w
  const uint32_t other = 0u << 30 | 0u << 20 | 0u << 10 | (0x200u | 511u);
  std::memcpy(b.rotation.data(), &other, 4);
  const Gaussians g = parse_gaussians("a.spz", gzip(spz_body(3, 0, {a, b})));
  const double x = std::sqrt(0.5), y = -std::sqrt(0.5) * 256 / 511;
  CHECK(g.rotation[0][0] == doctest::Approx(std::sqrt(1 - x * x - y * y)));
  CHECK(g.rotation[0][1] == doctest::Approx(x));
  CHECK(g.rotation[0][2] == doctest::Approx(y));
  CHECK(g.rotation[0][3] == 0);
  CHECK(g.rotation[1][0] == doctest::Approx(-x));
  CHECK(g.rotation[1][1] == doctest::Approx(x));
}

TEST_CASE("spz: harmonics come coefficient by coefficient, red green blue inside") {
  for (int degree = 1; degree <= 3; ++degree) {
    SpzGaussian a, b;
    for (int k = 0; k < 3 * (sh_coefficient_count(degree) - 1); ++k) {
      a.harmonics.push_back(static_cast<uint8_t>(128 + k));
      b.harmonics.push_back(static_cast<uint8_t>(128 - k));
    }
    const Gaussians g = parse_gaussians("a.spz", gzip(spz_body(3, degree, {a, b})));
    CHECK(g.sh_degree == degree);
    CHECK(g.sh_of(0)[1] == Eigen::Vector3f(0, 1 / 128.0f, 2 / 128.0f));
    CHECK(g.sh_of(1)[2] == Eigen::Vector3f(-3 / 128.0f, -4 / 128.0f, -5 / 128.0f));
  }
}

TEST_CASE("spz: hostile files end with a line that says what is wrong") {
  const std::string body = spz_body(3, 1, {SpzGaussian::with_degree(1), SpzGaussian::with_degree(1)});
  const std::string file = gzip(body);
  CHECK(error_of(file) == "no error");
  CHECK(contains(error_of(body), "version 4"));
  CHECK(contains(error_of(gzip("nothing")), "7 bytes"));
  CHECK(contains(error_of(gzip(std::string(64, 'x'))), "another gzip file"));
  const auto with = [&](size_t at, uint8_t value) {
    std::string changed = body;
    changed[at] = static_cast<char>(value);
    return error_of(gzip(changed));
  };
  CHECK(contains(with(4, 1), "version: found 1"));
  CHECK(contains(with(4, 4), "version: found 4"));
  CHECK(contains(with(8, 0), "numPoints: found 0"));
  CHECK(contains(with(8, 3), "for 3 Gaussians"));
  CHECK(contains(with(8, 1), "the end after 1 Gaussians"));
  CHECK(contains(with(11, 255), "numPoints: found 4278190082"));
  CHECK(contains(with(12, 4), "shDegree"));
  CHECK(contains(with(13, 24), "fractionalBits"));
  CHECK(contains(with(10, 64), "compressed bytes can hold"));  // 4 million Gaussians in a few bytes
  // Records that a flag announces may follow; nothing else may.
  std::string extended = body + "more";
  CHECK(contains(error_of(gzip(extended)), "the end after 2"));
  extended[14] = 2;
  CHECK(error_of(gzip(extended)) == "no error");
  // A bomb: a megabyte of zeros behind a header that asks for two Gaussians is never inflated.
  CHECK(contains(error_of(gzip(body + std::string(1 << 20, '\0'))), "the end after 2"));
  for (size_t n = 0; n < file.size(); ++n) CHECK(error_of(file.substr(0, n)) != "no error");
  std::string damaged = file;
  damaged[file.size() - 6] ^= 1;  // the checksum
  CHECK(contains(error_of(damaged), "damaged"));
}
