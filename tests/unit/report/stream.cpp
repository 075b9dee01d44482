#include "report/stream.h"

#include <doctest/doctest.h>
#include <omp.h>
#include <zlib.h>

#include <cmath>
#include <limits>

using namespace physmas;
using namespace physmas::report;

namespace {

Gaussians some_gaussians(size_t n, int degree) {
  Gaussians g;
  g.resize(n, degree);
  for (size_t i = 0; i < n; ++i) {
    const auto x = static_cast<float>(i);
    g.position[i] = {std::sin(x), std::cos(1.7f * x), std::sin(0.3f * x + 1)};
    g.log_scale[i] = {-4 + 0.5f * std::sin(x), -4, -5};
    g.rotation[i] = {1, 0.3f * std::sin(x), 0.2f, -0.1f};
    g.opacity_logit[i] = 2 * std::sin(x);
    for (int k = 0; k < sh_coefficient_count(degree); ++k)
      g.sh[i * static_cast<size_t>(sh_coefficient_count(degree)) + static_cast<size_t>(k)].setConstant(
          0.4f * std::sin(x + static_cast<float>(k)));
  }
  return g;
}

// Everything turns about z, moves, and stretches.
splat::TransportedFrame moved(const Gaussians& g, int t) {
  const float angle = 0.1f * static_cast<float>(t);
  splat::RowMatrix3f F;
  F << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0,
      1 + 0.01f * static_cast<float>(t);
  std::vector<Eigen::Vector3f> position;
  for (const Eigen::Vector3f& x : g.position)
    position.push_back(F * x + Eigen::Vector3f(0, 0, -0.02f * static_cast<float>(t * t)));
  return {position, std::vector<splat::RowMatrix3f>(g.size(), F)};
}

// A reader of its own, after the description in stream.h alone.
struct Reader {
  explicit Reader(const Stream& s) : stream(s) {}
  const Stream& stream;
  size_t at = 0, chunk = 0;
  std::string bytes;
  size_t place = 0;

  void next() {
    uLongf size = 100 << 20;
    bytes.resize(size);
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                       reinterpret_cast<const Bytef*>(stream.bytes.data() + at),
                       static_cast<uLong>(stream.chunk_bytes[chunk])) == Z_OK);
    bytes.resize(size);
    at += stream.chunk_bytes[chunk++];
    place = 0;
  }
  std::vector<long> plane(const std::vector<long>& last, const std::vector<long>& last_but_one) {
    const size_t n = stream.kept.size();
    const int prediction = bytes[place], width = bytes[place + 1];
    std::vector<long> values(n);
    long beside = 0;
    for (size_t i = 0; i < n; ++i) {
      unsigned long u = 0;
      for (int b = 0; b < width; ++b)
        u |= static_cast<unsigned long>(static_cast<unsigned char>(bytes[place + 2 + static_cast<size_t>(b) * n + i]))
             << (8 * b);
      long v = u % 2 == 0 ? static_cast<long>(u / 2) : -static_cast<long>((u + 1) / 2);
      if (prediction & 4) beside = v += beside;
      if ((prediction & 3) == 1) v += last[i];
      if ((prediction & 3) == 2) v += 2 * last[i] - last_but_one[i];
      values[i] = v;
    }
    place += 2 + static_cast<size_t>(width) * n;
    return values;
  }
};

}  // namespace

TEST_CASE("stream: what is read again is off by half a step at most, in every frame") {
  const Gaussians g = some_gaussians(300, 1);
  std::vector<int32_t> row(g.size());
  for (size_t i = 0; i < row.size(); ++i) row[i] = static_cast<int32_t>(i % 3);
  const int frames = 12;
  const Stream s = make_stream(g, row, 3, frames, [&](int t) { return moved(g, t); });
  REQUIRE(s.kept.size() == g.size());
  REQUIRE(s.frames.size() == frames);
  CHECK(s.sh_degree == 1);
  CHECK(s.cut == 0);
  Reader reader(s);
  reader.next();
  std::vector<std::vector<long>> rest;
  for (int k = 0; k < 14 + 9 + 1; ++k) rest.push_back(reader.plane({}, {}));
  CHECK(reader.place == reader.bytes.size());
  for (size_t k = 0; k < s.kept.size(); ++k) {
    const size_t i = s.kept[k];
    for (int c = 0; c < 3; ++c) {
      CHECK(std::abs(s.origin[c] + static_cast<double>(rest[static_cast<size_t>(c)][k]) * s.steps.rest -
                     g.position[i][c]) <= s.steps.rest * 0.501);
      CHECK(std::abs(static_cast<double>(rest[14 + static_cast<size_t>(c)][k]) * s.steps.harmonics -
                     g.sh_of(i)[1][c]) <= s.steps.harmonics * 0.501);
    }
    CHECK(std::abs(static_cast<double>(rest[10][k]) * s.steps.opacity - g.opacity(i)) <= s.steps.opacity * 0.501);
    CHECK(rest.back()[k] == row[i]);
    if (k > 0) CHECK(row[s.kept[k - 1]] <= row[i]);
  }
  std::vector<std::vector<long>> last(Stream::kComponents), before(Stream::kComponents);
  for (int t = 0; t < frames; ++t) {
    reader.next();
    const splat::TransportedFrame frame = moved(g, t);
    std::vector<std::vector<long>> now;
    for (size_t c = 0; c < Stream::kComponents; ++c) now.push_back(reader.plane(last[c], before[c]));
    CHECK(reader.place == reader.bytes.size());
    double worst = 0, worst_F = 0;
    for (size_t k = 0; k < s.kept.size(); ++k) {
      const size_t i = s.kept[k];
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(static_cast<double>(now[static_cast<size_t>(c)][k]) * s.steps.position -
                                         (frame.position(i)[c] - g.position[i][c])));
      for (int c = 0; c < 9; ++c)
        worst_F =
            std::max(worst_F, std::abs(static_cast<double>(now[3 + static_cast<size_t>(c)][k]) * s.steps.deformation -
                                       (frame.F(i)(c / 3, c % 3) - (c % 4 == 0))));
    }
    CHECK(worst <= s.steps.position * 0.501);
    CHECK(worst_F <= s.steps.deformation * 0.501);
    before = last;
    last = now;
  }
  CHECK(reader.at == s.bytes.size());
}

TEST_CASE("stream: the bytes do not depend on the number of threads") {
  const Gaussians g = some_gaussians(500, 0);
  const std::vector<int32_t> row(g.size(), 0);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Stream one = make_stream(g, row, 0, 20, [&](int t) { return moved(g, t); });
  omp_set_num_threads(3);
  const Stream three = make_stream(g, row, 0, 20, [&](int t) { return moved(g, t); });
  omp_set_num_threads(threads);
  CHECK(one.bytes == three.bytes);
  CHECK(one.chunk_bytes == three.chunk_bytes);
}

TEST_CASE("stream: a Gaussian that is not finite is hidden, one that flies off is cut, and both are counted") {
  const Gaussians g = some_gaussians(50, 0);
  const std::vector<int32_t> row(g.size(), 0);
  const auto frame = [&](int t) {
    splat::TransportedFrame all = moved(g, t);
    std::vector<Eigen::Vector3f> position;
    std::vector<splat::RowMatrix3f> F;
    for (size_t i = 0; i < g.size(); ++i) position.push_back(all.position(i)), F.push_back(all.F(i));
    if (t == 1) position[7].x() = std::numeric_limits<float>::quiet_NaN();
    if (t == 2) position[8].x() = 1e9f;
    return splat::TransportedFrame(position, F);
  };
  const Stream s = make_stream(g, row, 0, 3, frame);
  CHECK(s.hidden == 1);
  CHECK(s.cut == 1);
  Reader reader(s);
  reader.next();
  std::vector<std::vector<long>> last(Stream::kComponents), before(Stream::kComponents);
  for (int t = 0; t < 3; ++t) {
    reader.next();
    std::vector<std::vector<long>> now;
    for (size_t c = 0; c < Stream::kComponents; ++c) now.push_back(reader.plane(last[c], before[c]));
    for (size_t k = 0; k < s.kept.size(); ++k) {
      CHECK((now[3][k] == Stream::kHidden) == (t == 1 && s.kept[k] == 7));
      if (t == 2 && s.kept[k] == 8) CHECK(now[0][k] == 32767);
    }
    before = last;
    last = now;
  }
}

TEST_CASE(
    "stream: above a limit it has fewer frames, always the first and the last, and the Gaussians that cover most") {
  Gaussians g = some_gaussians(100, 0);
  for (size_t i = 0; i < g.size(); ++i) g.opacity_logit[i] = 0, g.log_scale[i].setConstant(i < 40 ? -2.0f : -6.0f);
  const std::vector<int32_t> row(g.size(), 0);
  StreamLimits limits;
  limits.gaussians = 40;
  limits.gaussian_frames = 400;
  Stream s = make_stream(
      g, row, 0, 21, [&](int t) { return moved(g, t); }, limits);
  CHECK(s.kept.size() == 40);
  for (const size_t i : s.kept) CHECK(i < 40);
  CHECK(s.frames.size() <= 10);
  CHECK(s.frames.size() >= 8);
  CHECK(s.frames.front() == 0);
  CHECK(s.frames.back() == 20);
  limits = {};
  const size_t whole = make_stream(g, row, 0, 21, [&](int t) { return moved(g, t); }).bytes.size();
  limits.bytes = whole / 2;
  s = make_stream(
      g, row, 0, 21, [&](int t) { return moved(g, t); }, limits);
  CHECK(s.bytes.size() <= whole / 2);
  CHECK(s.frames.size() >= 3);
  CHECK(s.frames.back() == 20);
}
