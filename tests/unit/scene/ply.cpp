#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>

#include "base/error.h"
#include "base/file.h"
#include "scene/gaussian_files.h"
#include "unit/skip_test.h"
#include "unit/temporary_folder.h"

namespace {

using physmas::Error;
using physmas::ExitCode;
using physmas::Gaussians;
using physmas::parse_gaussians;

Gaussians random_gaussians(size_t n, int degree, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-2, 2);
  Gaussians g;
  g.resize(n, degree);
  for (size_t i = 0; i < n; ++i) {
    g.position[i] = {u(random), u(random), u(random)};
    g.log_scale[i] = {u(random), u(random), u(random)};
    g.rotation[i] = {u(random), u(random), u(random), 0.1f + std::abs(u(random))};
    g.opacity_logit[i] = u(random);
  }
  for (auto& sh : g.sh) sh = {u(random), u(random), u(random)};
  return g;
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool same(const Gaussians& a, const Gaussians& b) {
  return a.sh_degree == b.sh_degree && same_bits(a.position, b.position) && same_bits(a.log_scale, b.log_scale) &&
         same_bits(a.rotation, b.rotation) && same_bits(a.opacity_logit, b.opacity_logit) && same_bits(a.sh, b.sh);
}

template <typename T>
void put(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

// Columns of a degree-0 Gaussian in an order that INRIA's code does not use.
const std::vector<std::string> kColumns = {"opacity", "rot_0",   "rot_1",   "rot_2",   "rot_3",  "z",      "y",
                                           "x",       "scale_0", "scale_1", "scale_2", "f_dc_0", "f_dc_1", "f_dc_2"};
const std::vector<float> kValues = {0.5f, 1, 0, 0, 0, 3, 2, 1, -1, -2, -3, 0.25f, 0.5f, 0.75f};

std::string header(const std::string& format, const std::string& count,
                   const std::vector<std::string>& columns = kColumns, const std::string& type = "float") {
  std::string text = "ply\nformat " + format + " 1.0\nelement vertex " + count + "\n";
  for (const std::string& column : columns) text += "property " + type + " " + column + "\n";
  return text + "end_header\n";
}

std::string body(std::vector<float> values = kValues) {
  std::string bytes;
  for (float v : values) put(bytes, v);
  return bytes;
}

// The one line that reading `bytes` ends with; empty when it succeeds.
std::string error_of(const std::string& bytes, const std::string& path = "in.ply") {
  try {
    parse_gaussians(path, bytes);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::invalid_input);
    const std::string text = error.what();
    CHECK(text.find('\n') == std::string::npos);
    CHECK(text.rfind(path, 0) == 0);
    return text;
  }
  return "";
}

void check_error(const std::string& bytes, const std::vector<std::string>& parts, const std::string& path = "in.ply") {
  const std::string text = error_of(bytes, path);
  for (const std::string& part : parts) {
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
  }
}

std::string shared_data(const std::string& name) {
  const std::string path = "../shared/data/" + name;
  if (std::filesystem::exists(path)) return path;
  skip_test("no " + path);
  return "";
}

}  // namespace

TEST_CASE("ply: round trip keeps every value bit for bit at every degree") {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const Gaussians g = random_gaussians(37, degree, 7 + degree);
    const std::string path = folder / "a.ply";
    CHECK(physmas::save_gaussians_ply(path, g));
    CHECK_FALSE(physmas::save_gaussians_ply(path, g));
    CHECK(same(physmas::load_gaussians(path), g));
  }
}

TEST_CASE("ply: a real file survives a round trip value for value") {
  const std::string path = shared_data("udon.ply");
  if (path.empty()) return;
  const TemporaryFolder folder;
  const Gaussians g = physmas::load_gaussians(path);
  CHECK(g.size() == 2153);
  CHECK(g.sh_degree == 3);
  physmas::save_gaussians_ply(folder / "b.ply", g);
  CHECK(same(physmas::load_gaussians(folder / "b.ply"), g));
}

TEST_CASE("ply: f_rest is channel-major") {
  std::vector<std::string> columns = kColumns;
  std::vector<float> values = kValues;
  for (int i = 0; i < 24; ++i) columns.push_back(fmt::format("f_rest_{}", i)), values.push_back(static_cast<float>(i));
  const Gaussians g = parse_gaussians("in.ply", header("binary_little_endian", "1", columns) + body(values));
  CHECK(g.sh_degree == 2);
  CHECK(g.sh_of(0)[1] == Eigen::Vector3f(0, 8, 16));
  CHECK(g.sh_of(0)[8] == Eigen::Vector3f(7, 15, 23));
}

TEST_CASE("ply: formats, types, line ends and foreign elements do not change what is read") {
  const Gaussians expected = parse_gaussians("in.ply", header("binary_little_endian", "1") + body());
  CHECK(expected.position[0] == Eigen::Vector3f(1, 2, 3));
  CHECK(expected.log_scale[0] == Eigen::Vector3f(-1, -2, -3));
  CHECK(expected.sh[0] == Eigen::Vector3f(0.25f, 0.5f, 0.75f));
  CHECK(expected.opacity_logit[0] == 0.5f);

  std::string big = header("binary_big_endian", "1");
  for (float v : kValues) put(big, v, true);
  CHECK(same(parse_gaussians("in.ply", big), expected));

  std::string wide = header("binary_little_endian", "1", kColumns, "double");
  for (float v : kValues) put(wide, static_cast<double>(v));
  CHECK(same(parse_gaussians("in.ply", wide), expected));

  std::string text = header("ascii", "1");
  for (float v : kValues) text += fmt::format("{} ", v);
  CHECK(same(parse_gaussians("in.ply", text), expected));
  std::string windows;
  for (char c : text + "\n") windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  CHECK(same(parse_gaussians("in.ply", windows), expected));

  // A list element before the Gaussians, an extra property among them, another element after them.
  std::vector<std::string> columns = kColumns;
  columns.insert(columns.begin() + 3, "confidence");
  std::vector<float> values = kValues;
  values.insert(values.begin() + 3, 99.0f);
  std::string foreign = header("binary_little_endian", "1", columns);
  foreign.insert(foreign.find("element vertex"), "comment x\nelement face 2\nproperty list uchar int vertex_index\n");
  foreign.insert(foreign.find("end_header"), "element camera 1\nproperty short id\n");
  for (uint8_t length : {uint8_t{3}, uint8_t{0}}) {
    put(foreign, length);
    for (int i = 0; i < length; ++i) put(foreign, i);
  }
  foreign += body(values);
  put(foreign, int16_t{5});
  CHECK(same(parse_gaussians("in.ply", foreign), expected));
}

TEST_CASE("ply: ascii floats are read exactly") {
  std::string text = header("ascii", "1");
  std::vector<float> values = kValues;
  values[5] = 0.1f, values[6] = 1.17549435e-38f, values[7] = 16777217.0f;
  for (float v : values) text += fmt::format("{} ", v);
  const Gaussians g = parse_gaussians("in.ply", text);
  CHECK(g.position[0] == Eigen::Vector3f(values[7], values[6], values[5]));
}

TEST_CASE("ply: hostile headers end with a line that says what is wrong") {
  const std::string little = "binary_little_endian";
  check_error("", {"empty file"});
  check_error("plx\n", {"byte 0", "PLY magic"});
  check_error("ply\nformat binary_little_endian 1.0\nelement vertex 1\n", {"header", "end_header"});
  check_error("ply\n" + std::string(3 << 20, 'x'), {"header", "end_header"});
  check_error("ply\nend_header\n", {"no format line"});
  check_error("ply\nformat ascii 2.0\nend_header\n", {"line 2", "format"});
  check_error("ply\nformat binary_middle_endian 1.0\nend_header\n", {"line 2", "binary_big_endian"});
  check_error(header(little, "-5") + body(), {"line 3", "row count"});
  check_error(header(little, "99999999999999999999999") + body(), {"line 3", "row count"});
  check_error(header(little, "18446744073709551615") + body(), {"element vertex", "18446744073709551615 rows"});
  check_error(header("ascii", "1000000000000") + "1 2 3", {"element vertex", "1000000000000 rows"});
  check_error(header(little, "0"), {"element vertex", "no Gaussians"});
  check_error(header(little, "1", kColumns, "quad") + body(), {"line 4", "PLY type"});
  check_error(header(little, "1", {"x", "y", "x"}), {"line 6", "every property once"});
  check_error("ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 1\nend_header\n",
              {"line 4", "every element once"});
  check_error("ply\nformat ascii 1.0\nproperty float x\nend_header\n", {"line 3", "before its properties"});
  check_error("ply\nformat ascii 1.0\nwhatever\nend_header\n", {"line 3", "whatever"});
  check_error("ply\nformat ascii 1.0\nelement e 1\nproperty list float int i\nend_header\n", {"integer type"});
  check_error("ply\nformat ascii 1.0\nend_header\n", {"no element vertex"});
  for (size_t missing = 0; missing < kColumns.size(); ++missing) {
    if (kColumns[missing] == "scale_2") continue;  // 2D Gaussians have two
    std::vector<std::string> columns = kColumns;
    columns.erase(columns.begin() + missing);
    check_error(header(little, "1", columns) + body().substr(4),
                {"element vertex", "no property " + kColumns[missing]});
  }
  std::vector<std::string> columns = kColumns;
  columns.push_back("f_rest_0");
  check_error(header(little, "1", columns) + body() + "0000", {"1 f_rest_* properties", "0, 9, 24, 45 or 72"});
}

TEST_CASE("ply: hostile bodies end with a line that says what is wrong") {
  const std::string little = "binary_little_endian";
  check_error(header(little, "2") + body(), {"element vertex", "2 rows of 56 bytes", "cut off"});
  check_error(header(little, "1") + body().substr(1), {"55 bytes", "1 rows of 56 bytes"});
  check_error(header(little, "1") + "0.5 1 0 0 0 3 2 1 -1 -2 -3 0.25 0.5 0.75\n", {"found text", "ascii"});
  check_error(header("ascii", "1") + body(), {"element vertex"});
  check_error(header("ascii", "1") + "0.5 1 0 0 0 3 2 1 -1 -2 -3 0.25 0.5",
              {"element vertex row 0", "end of the file"});
  check_error(header("ascii", "1") + "0.5 1 0 0 0 3 2 1 -1 -2 -3 0.25 0.5 1x", {"f_dc_2", "\"1x\"", "a number"});
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  for (size_t k = 0; k < kValues.size(); ++k) {
    for (float bad : {nan, infinity, -infinity}) {
      std::vector<float> values = kValues;
      values.insert(values.end(), kValues.begin(), kValues.end());
      if (kColumns[k] == "opacity" && std::isinf(bad)) continue;              // 0 or 1
      if (kColumns[k].rfind("scale_", 0) == 0 && bad == -infinity) continue;  // flat
      values[kValues.size() + k] = bad;
      check_error(header(little, "2") + body(values), {"row 1 property " + kColumns[k], "finite"});
    }
  }
  for (float tiny : {0.0f, 1e-30f}) {
    std::vector<float> values = kValues;
    values[1] = tiny;
    check_error(header(little, "1") + body(values), {"row 0", "rot_0..3", "quaternion of length"});
  }
  std::string lists = header(little, "1");
  lists.insert(lists.find("element vertex"), "element face 1\nproperty list int double v\n");
  for (int32_t length : {-1, 1000000, std::numeric_limits<int32_t>::max()}) {
    std::string bytes = lists;
    put(bytes, length);
    check_error(bytes + body(), {"element face row 0 property v"});
  }
}

TEST_CASE("ply: no prefix and no flipped byte crashes the reader") {
  std::string whole = header("binary_little_endian", "2") + body() + body();
  for (size_t n = 0; n < whole.size(); ++n) CHECK(error_of(whole.substr(0, n)) != "");
  std::mt19937 random(3);
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = whole;
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    error_of(bytes);
  }
}

namespace {

// A compressed file with one chunk; `color` adds colour bounds, `degree` an sh element.
std::string compressed(const std::vector<std::array<uint32_t, 4>>& packed, bool color, int degree, uint8_t sh_byte,
                       int chunk_count = 1) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\nelement chunk {}\n", chunk_count);
  for (const char* kind : {"", "scale_"}) {
    for (const char* bound : {"min_", "max_"}) {
      for (const char* axis : {"x", "y", "z"}) text += fmt::format("property float {}{}{}\n", bound, kind, axis);
    }
  }
  if (color) {
    for (const char* name : {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"}) {
      text += fmt::format("property float {}\n", name);
    }
  }
  text += fmt::format("element vertex {}\n", packed.size());
  for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"}) {
    text += fmt::format("property uint {}\n", name);
  }
  const int rest = 3 * (physmas::sh_coefficient_count(degree) - 1);
  if (degree > 0) {
    text += fmt::format("element sh {}\n", packed.size());
    for (int k = 0; k < rest; ++k) text += fmt::format("property uchar f_rest_{}\n", k);
  }
  text += "end_header\n";
  for (int c = 0; c < chunk_count; ++c) {
    for (float v : {-1.0f, -2.0f, -3.0f, 1.0f, 2.0f, 3.0f, -8.0f, -8.0f, -8.0f, 0.0f, 0.0f, 0.0f}) put(text, v);
    if (color) {
      for (float v : {-0.5f, 0.0f, 0.25f, 1.5f, 1.0f, 0.75f}) put(text, v);
    }
  }
  for (const auto& words : packed) {
    for (uint32_t word : words) put(text, word);
  }
  for (size_t i = 0; i < packed.size() * rest; ++i) text += static_cast<char>(sh_byte);
  return text;
}

}  // namespace

TEST_CASE("ply: compressed values decode to what was packed") {
  // Position: x at its top, y in the middle (512 of 1023), z at its bottom. Rotation: w largest, then z largest.
  const uint32_t position = (2047u << 21) | (512u << 11) | 0u;
  const uint32_t rotation_w = (0u << 30) | (512u << 20) | (256u << 10) | 1023u;
  const uint32_t rotation_z = (3u << 30) | (0u << 20) | (512u << 10) | 512u;
  const uint32_t scale = (0u << 21) | (1023u << 11) | 1024u;
  const uint32_t color = (255u << 24) | (0u << 16) | (51u << 8) | 204u;
  const Gaussians g = parse_gaussians(
      "in.ply",
      compressed({{position, rotation_w, scale, color}, {position, rotation_z, scale, color & ~0xffu}}, true, 1, 128));
  REQUIRE(g.size() == 2);
  CHECK(g.sh_degree == 1);
  CHECK(g.position[0].x() == doctest::Approx(1));
  CHECK(g.position[0].y() == doctest::Approx(-2 + 4 * 512.0 / 1023));
  CHECK(g.position[0].z() == doctest::Approx(-3));
  CHECK(g.log_scale[0].x() == doctest::Approx(-8));
  CHECK(g.log_scale[0].y() == doctest::Approx(0));
  CHECK(g.log_scale[0].z() == doctest::Approx(-8 + 8 * 1024.0 / 2047));
  const double a = (512.0 / 1023 - 0.5) * std::sqrt(2.0), b = (256.0 / 1023 - 0.5) * std::sqrt(2.0),
               c = 0.5 * std::sqrt(2.0);
  CHECK(g.rotation[0][1] == doctest::Approx(a));
  CHECK(g.rotation[0][2] == doctest::Approx(b));
  CHECK(g.rotation[0][3] == doctest::Approx(c));
  CHECK(g.rotation[0][0] == doctest::Approx(std::sqrt(1 - a * a - b * b - c * c)));
  CHECK(g.rotation[1][0] == doctest::Approx(-c));
  CHECK(g.rotation[1][3] == doctest::Approx(std::sqrt(1 - c * c - 2 * a * a)));
  // Colours: red at its upper bound 1.5, green at 0, blue a fifth of the way from 0.25 to 0.75.
  CHECK(0.5 + 0.28209479177387814 * g.sh_of(0)[0][0] == doctest::Approx(1.5));
  CHECK(0.5 + 0.28209479177387814 * g.sh_of(0)[0][1] == doctest::Approx(0).epsilon(1e-6));
  CHECK(0.5 + 0.28209479177387814 * g.sh_of(0)[0][2] == doctest::Approx(0.35));
  CHECK(g.opacity(0) == doctest::Approx(0.8));
  CHECK(g.opacity(1) == doctest::Approx(1e-6));
  CHECK(g.sh_of(0)[1].x() == doctest::Approx((128.5 / 256 - 0.5) * 8));

  const Gaussians plain = parse_gaussians("in.ply", compressed({{position, rotation_w, scale, color}}, false, 0, 0));
  CHECK(0.5 + 0.28209479177387814 * plain.sh_of(0)[0][2] == doctest::Approx(0.2));
  const Gaussians third = parse_gaussians("in.ply", compressed({{position, rotation_w, scale, color}}, true, 3, 0));
  CHECK(third.sh_of(0)[15] == Eigen::Vector3f(-4, -4, -4));
}

TEST_CASE("ply: hostile compressed files") {
  const std::array<uint32_t, 4> words = {0, 0, 0, 0};
  check_error(compressed({words}, true, 0, 0, 2), {"element chunk", "2 rows", "1 for 1 Gaussians"});
  check_error(compressed(std::vector<std::array<uint32_t, 4>>(257, words), true, 0, 0), {"element chunk", "2 for 257"});
  const std::string good = compressed({words}, true, 1, 0);
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  check_error(replaced("min_scale_y", "min_scale_q"), {"element chunk", "min_scale_y"});
  check_error(replaced("property uint packed_scale", "property int packed_scale"), {"packed_scale", "uint"});
  check_error(replaced("element sh 1", "element sh 0"), {"element sh", "0 rows"});
  check_error(replaced("property uchar f_rest_8", "property uchar other"), {"element sh", "f_rest_8"});
  check_error(good.substr(0, good.size() - 1), {"element sh", "cut off"});
}

TEST_CASE("ply: .splat files decode, and hostile ones are refused") {
  std::string bytes;
  for (float v : {1.0f, 2.0f, 3.0f, 0.5f, 1.0f, 0.0f}) put(bytes, v);
  for (int b : {255, 0, 51, 204, 255, 128, 0, 192}) bytes += static_cast<char>(b);
  const Gaussians g = parse_gaussians("a.splat", bytes);
  CHECK(g.position[0] == Eigen::Vector3f(1, 2, 3));
  CHECK(g.log_scale[0].x() == doctest::Approx(std::log(0.5)));
  CHECK(std::isfinite(g.log_scale[0].z()));
  CHECK(0.5 + 0.28209479177387814 * g.sh[0][0] == doctest::Approx(1));
  CHECK(g.opacity(0) == doctest::Approx(0.8));
  CHECK(g.rotation[0] == std::array<float, 4>{127.0f / 128, 0, -1, 0.5f});

  check_error("", {"size"}, "a.splat");
  check_error(bytes + "x", {"33 bytes", "multiple of 32"}, "a.splat");
  std::string bad = bytes;
  std::memset(&bad[28], 128, 4);
  check_error(bytes + bad, {"Gaussian 1", "quaternion"}, "a.splat");
  bad = bytes;
  const float negative = -1;
  std::memcpy(&bad[16], &negative, 4);
  check_error(bad, {"Gaussian 0 scale_1", "byte 16"}, "a.splat");
  bad = bytes;
  bad[3] = bad[2] = static_cast<char>(0xff);
  check_error(bad, {"Gaussian 0 property x", "finite"}, "a.splat");
}

TEST_CASE("ply: a real compressed file lies within its bounds") {
  const std::string path = shared_data("guitar.compressed.ply");
  if (path.empty()) return;
  const Gaussians g = physmas::load_gaussians(path);
  CHECK(g.size() == 90854);
  CHECK(g.sh_degree == 0);
  Eigen::Vector3f low = g.position[0], high = g.position[0];
  for (const auto& p : g.position) low = low.cwiseMin(p), high = high.cwiseMax(p);
  CHECK((high - low).maxCoeff() == doctest::Approx(4.3).epsilon(0.1));
}
