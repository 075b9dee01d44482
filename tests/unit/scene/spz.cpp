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
  CHECK(contains(error_of(gzip("nothing")), "no PLY magic"));
  CHECK(contains(error_of(gzip("NGSP")), "4 bytes"));
  const auto with = [&](size_t at, uint8_t value) {
    std::string changed = body;
    changed[at] = static_cast<char>(value);
    return error_of(gzip(changed));
  };
  CHECK(contains(with(4, 0), "version: found 0"));
  CHECK(contains(with(4, 5), "version: found 5"));
  CHECK(contains(with(8, 0), "numPoints: found 0"));
  CHECK(contains(with(8, 3), "for 3 Gaussians"));
  CHECK(contains(with(8, 1), "the end after 1 Gaussians"));
  CHECK(contains(with(11, 255), "numPoints: found 4278190082"));
  CHECK(contains(with(12, 5), "shDegree"));
  CHECK(contains(with(13, 24), "fractionalBits"));
  CHECK(contains(with(10, 64), "compressed bytes can hold"));  // 4 million Gaussians in a few bytes
  // Records that a flag announces may follow; nothing else may.
  std::string extended = body + "more";
  CHECK(contains(error_of(gzip(extended)), "the end after 2"));
  extended[14] = 2;
  CHECK(contains(error_of(gzip(extended)), "extension at byte 0"));
  extended += std::string(4, '\0');  // a type, and a length of 0
  CHECK(error_of(gzip(extended)) == "no error");
  // A bomb: a megabyte of zeros behind a header that asks for two Gaussians is never inflated.
  CHECK(contains(error_of(gzip(body + std::string(1 << 20, '\0'))), "the end after 2"));
  for (size_t n = 0; n < file.size(); ++n) CHECK(error_of(file.substr(0, n)) != "no error");
  std::string damaged = file;
  damaged[file.size() - 6] ^= 1;  // the checksum
  CHECK(contains(error_of(damaged), "damaged"));
}

TEST_CASE("spz: version 1 has halves for positions") {
  SpzGaussian a;
  a.position = {0x3c00, 0xc100, 0x0001};  // 1, -2.5, the smallest
  const Gaussians g = parse_gaussians("a.spz", gzip(spz_body(1, 0, {a})));
  CHECK(g.position[0] == Eigen::Vector3f(1, -2.5f, std::ldexp(1.0f, -24)));
  CHECK(g.log_scale[0] == Eigen::Vector3f(-3.75f, -3.75f, -3.75f));
}

TEST_CASE("spz: version 4 holds the values of version 3") {
  for (int degree = 0; degree <= 3; ++degree) {
    SpzGaussian a = SpzGaussian::with_degree(degree), b = a;
    a.position = {-4096, 6144, 77};
    for (size_t k = 0; k < b.harmonics.size(); ++k) b.harmonics[k] = static_cast<uint8_t>(100 + k);
    const std::string body = spz_body(3, degree, {a, b});
    const Gaussians g = parse_gaussians("a.spz", spz4(body)), old = parse_gaussians("a.spz", gzip(body));
    CHECK(g.sh_degree == degree);
    CHECK(g.position == old.position);
    CHECK(g.rotation == old.rotation);
    CHECK(g.sh == old.sh);
    CHECK(g.log_scale == old.log_scale);
    CHECK(g.opacity_logit == old.opacity_logit);
  }
}

TEST_CASE("spz: degree 4 is cut to 3 and said") {
  SpzGaussian a;
  for (int k = 0; k < 72; ++k) a.harmonics.push_back(static_cast<uint8_t>(128 + k));
  for (const std::string& bytes : {gzip(spz_body(3, 4, {a, a})), spz4(spz_body(3, 4, {a, a}))}) {
    const GaussianFile file = parse_gaussian_file("a.spz", bytes);
    CHECK(file.gaussians.sh_degree == 3);
    for (int k = 0; k < 15; ++k) {
      CHECK(file.gaussians.sh_of(1)[k + 1] ==
            Eigen::Vector3f(3 * k / 128.0f, (3 * k + 1) / 128.0f, (3 * k + 2) / 128.0f));
    }
    REQUIRE(file.notes.notes.size() == 1);
    CHECK(contains(file.notes.notes[0], "degree 4"));
  }
}

TEST_CASE("spz: what the file says of its axes and of its training is followed") {
  SpzGaussian a = SpzGaussian::with_degree(1);
  a.position = {4096, 8192, 12288};
  a.harmonics = {138, 138, 138, 148, 148, 148, 158, 158, 158};  // along y, z and x
  const uint32_t turn = 3u << 30 | 100u << 20 | 200u << 10 | 300u;
  std::memcpy(a.rotation.data(), &turn, 4);
  const auto with_system = [&](uint32_t system) {
    std::string records("\x03\x00\xbe\xad\x04\x00\x00\x00", 8);
    for (int k = 0; k < 4; ++k) records += static_cast<char>(system >> 8 * k & 255);
    return parse_gaussian_file("a.spz", spz4(spz_body(3, 1, {a}), 0, records));
  };
  const GaussianFile plain = parse_gaussian_file("a.spz", spz4(spz_body(3, 1, {a})));
  CHECK(plain.notes.up == "y");
  CHECK(plain.notes.notes.empty());
  const GaussianFile down = with_system(6);  // right, down, front
  CHECK(down.notes.up == "-y");
  CHECK(down.gaussians.position == plain.gaussians.position);
  const GaussianFile unity = with_system(8);  // right, up, front: left-handed
  CHECK(unity.notes.up == "y");
  CHECK(unity.gaussians.position[0] == Eigen::Vector3f(1, 2, -3));
  const auto &q = unity.gaussians.rotation[0], &old = plain.gaussians.rotation[0];
  CHECK(q == std::array<float, 4>{old[0], -old[1], -old[2], old[3]});
  // Mirrored, every direction shows the colour that its mirror image showed.
  const Eigen::Vector3f *sh = unity.gaussians.sh_of(0), *before = plain.gaussians.sh_of(0);
  CHECK(sh[1] == before[1]);
  CHECK(sh[2] == Eigen::Vector3f(-before[2]));
  CHECK(sh[3] == before[3]);
  CHECK(with_system(12).notes.up == "z");
  CHECK(with_system(99).notes.warnings.size() == 1);
  CHECK(parse_gaussian_file("a.spz", spz4(spz_body(3, 1, {a}), 1)).gaussians.antialiased);
  CHECK_FALSE(plain.gaussians.antialiased);
}

TEST_CASE("spz: hostile files of version 4 end with a line that says what is wrong") {
  const std::string file = spz4(spz_body(3, 1, {SpzGaussian::with_degree(1), SpzGaussian::with_degree(1)}));
  CHECK(error_of(file) == "no error");
  for (size_t n = 0; n < file.size(); ++n) CHECK(error_of(file.substr(0, n)) != "no error");
  CHECK(contains(error_of(file + "x"), "1 more bytes"));
  const auto with = [&](size_t at, uint8_t value) {
    std::string changed = file;
    changed[at] = static_cast<char>(value);
    return error_of(changed);
  };
  CHECK(contains(with(4, 3), "without gzip"));
  CHECK(contains(with(11, 255), "numPoints"));
  CHECK(contains(with(15, 4), "numStreams: found 4"));
  CHECK(contains(with(17, 255), "tocByteOffset"));
  CHECK(contains(with(16, 31), "tocByteOffset"));
  CHECK(contains(with(32 + 7, 1), "compressed bytes"));
  CHECK(contains(with(32 + 8, 1), "stream 0"));
  CHECK(contains(with(file.size() - 1, 0), "stream 5"));
}
