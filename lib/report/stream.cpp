#include "report/stream.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "splat/middle_box.h"

namespace physmas::report {
namespace {

using Values = std::vector<int32_t>;

constexpr int kRange = 32767;
constexpr int kFrameBatch = 8;  // frames that are packed side by side

uint32_t zigzag(int64_t value) {
  return static_cast<uint32_t>(value >= 0 ? 2 * value : -2 * value - 1);
}

int bit_length(uint32_t value) {
  return value == 0 ? 0 : 32 - __builtin_clz(value);
}

int32_t rounded(double value, double step, int64_t range = std::numeric_limits<int32_t>::max() / 4) {
  const double q = std::nearbyint(value / step);
  return static_cast<int32_t>(std::clamp(q, -static_cast<double>(range), static_cast<double>(range)));
}

// What is left of `values` after a prediction; before: the frames before, the last one first.
void predict(const Values& values, const std::array<const Values*, 2>& before, int prediction,
             std::vector<uint32_t>& left) {
  const int order = prediction & 3;
  const bool beside = (prediction & 4) != 0;
  int64_t last = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    int64_t rest = values[i];
    if (order == 1) rest -= (*before[0])[i];
    if (order == 2) rest -= 2 * static_cast<int64_t>((*before[0])[i]) - (*before[1])[i];
    left[i] = zigzag(beside ? rest - last : rest);
    last = rest;
  }
}

// Appends a plane with the prediction that leaves the fewest bits.
void append_plane(const Values& values, const std::array<const Values*, 2>& before, std::string& out) {
  std::vector<uint32_t> left(values.size()), best;
  uint64_t fewest = std::numeric_limits<uint64_t>::max();
  int chosen = 0;
  const int orders = before[0] == nullptr ? 1 : before[1] == nullptr ? 2 : 3;
  for (int beside = 0; beside < 2; ++beside) {
    for (int order = 0; order < orders; ++order) {
      const int prediction = order | beside << 2;
      predict(values, before, prediction, left);
      uint64_t bits = 0;
      for (const uint32_t u : left) bits += static_cast<uint64_t>(bit_length(u));
      if (bits >= fewest) continue;
      fewest = bits;
      chosen = prediction;
      best = left;
    }
  }
  uint32_t largest = 0;
  for (const uint32_t u : best) largest = std::max(largest, u);
  const int width = std::max(1, (bit_length(largest) + 7) / 8);
  out += static_cast<char>(chosen);
  out += static_cast<char>(width);
  for (int b = 0; b < width; ++b) {
    for (const uint32_t u : best) out += static_cast<char>(u >> (8 * b) & 255);
  }
}

std::string deflated(const std::string& bytes) {
  z_stream stream = {};
  // What predictions leave is noise with many zeros: short matches cost more than they save.
  if (deflateInit2(&stream, 6, Z_DEFLATED, 15, 9, Z_FILTERED) != Z_OK) throw internal_error("deflate does not start");
  std::string packed(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int status = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw internal_error("deflate does not end");
  return packed;
}

// The Gaussians that are kept, by row and along a Morton curve within each.
std::vector<size_t> chosen_gaussians(const Gaussians& gaussians, const std::vector<int32_t>& row, size_t limit) {
  std::vector<size_t> kept(gaussians.size());
  std::iota(kept.begin(), kept.end(), size_t{0});
  if (kept.size() > limit) {
    std::vector<float> covers(gaussians.size());
    for (size_t i = 0; i < covers.size(); ++i) {
      std::array<float, 3> s = {gaussians.log_scale[i][0], gaussians.log_scale[i][1], gaussians.log_scale[i][2]};
      std::sort(s.begin(), s.end());
      covers[i] = std::log(std::max(gaussians.opacity(i), 1e-6f)) + s[1] + s[2];
    }
    std::stable_sort(kept.begin(), kept.end(), [&](size_t a, size_t b) { return covers[a] > covers[b]; });
    kept.resize(limit);
  }
  const Eigen::AlignedBox3d box = splat::middle_box(gaussians);
  const Eigen::Vector3d low = box.min() - box.sizes(), sizes = (3 * box.sizes()).cwiseMax(1e-12);
  std::vector<uint64_t> key(gaussians.size());
  for (const size_t i : kept) {
    const Eigen::Vector3d x = (gaussians.position[i].cast<double>() - low).cwiseQuotient(sizes);
    uint64_t code = 0;
    for (int c = 0; c < 3; ++c) {
      const auto cell = static_cast<uint64_t>(std::clamp(x[c] * 65536, 0.0, 65535.0));
      for (int b = 0; b < 16; ++b) code |= (cell >> b & 1) << (3 * b + c);
    }
    key[i] = code;
  }
  std::sort(kept.begin(), kept.end(), [&](size_t a, size_t b) {
    if (row[a] != row[b]) return row[a] < row[b];
    return key[a] != key[b] ? key[a] < key[b] : a < b;
  });
  return kept;
}

StreamSteps steps_of(const Gaussians& gaussians) {
  double diagonal = splat::middle_box(gaussians).sizes().norm();
  if (!(diagonal > 0) || !std::isfinite(diagonal)) diagonal = 1;
  StreamSteps steps;
  steps.position = diagonal / 8192;
  steps.deformation = 1.0 / 128;
  steps.rest = steps.position / 16;
  steps.log_scale = 1.0 / 64;
  steps.rotation = 1.0 / 1024;
  steps.opacity = 1.0 / 512;
  steps.color = 1.0 / 512;
  // The page keeps a byte for each.
  float largest = 0;
  const size_t count = static_cast<size_t>(sh_coefficient_count(gaussians.sh_degree));
  for (size_t k = 0; k < gaussians.sh.size(); ++k) {
    if (k % count != 0) largest = std::max(largest, gaussians.sh[k].cwiseAbs().maxCoeff());
  }
  steps.harmonics = std::max(largest / 127.0, 1e-6);
  return steps;
}

std::string rest_chunk(const Gaussians& g, const std::vector<int32_t>& row, const Stream& s) {
  std::vector<Values> planes;
  const auto add = [&](double step, const auto& value_of, int64_t range = std::numeric_limits<int32_t>::max() / 4) {
    Values values;
    for (const size_t i : s.kept) values.push_back(rounded(value_of(i), step, range));
    planes.push_back(std::move(values));
  };
  for (int c = 0; c < 3; ++c)
    add(s.steps.rest, [&](size_t i) { return static_cast<double>(g.position[i][c]) - s.origin[c]; });
  for (int c = 0; c < 3; ++c)
    add(s.steps.log_scale, [&](size_t i) { return std::clamp<double>(g.log_scale[i][c], -60, 60); });
  for (int c = 0; c < 4; ++c) {
    add(s.steps.rotation, [&](size_t i) {
      const std::array<float, 4>& q = g.rotation[i];
      const double norm =
          std::sqrt(double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] + double(q[3]) * q[3]);
      return (q[0] < 0 ? -q[c] : q[c]) / norm;
    });
  }
  add(s.steps.opacity, [&](size_t i) { return static_cast<double>(g.opacity(i)); });
  for (int c = 0; c < 3; ++c)
    add(
        s.steps.color, [&](size_t i) { return static_cast<double>(g.base_color(i)[c]); }, 1 << 20);
  const int count = sh_coefficient_count(s.sh_degree);
  for (int k = 1; k < count; ++k) {
    for (int c = 0; c < 3; ++c)
      add(
          s.steps.harmonics, [&](size_t i) { return static_cast<double>(g.sh_of(i)[k][c]); }, 127);
  }
  add(1, [&](size_t i) { return static_cast<double>(row[i]); });
  std::string chunk;
  for (const Values& values : planes) append_plane(values, {}, chunk);
  return chunk;
}

using FrameValues = std::array<Values, Stream::kComponents>;

struct Quantised {
  FrameValues values;
  long cut = 0, hidden = 0;
};

// before: the values that a Gaussian keeps while it is not finite, so that it costs nothing; or null.
Quantised quantised(const Gaussians& g, const splat::TransportedFrame& frame, const Stream& s,
                    const FrameValues* before) {
  Quantised q;
  for (Values& values : q.values) values.resize(s.kept.size());
  for (size_t k = 0; k < s.kept.size(); ++k) {
    const size_t i = s.kept[k];
    if (!frame.position(i).allFinite() || !frame.F(i).allFinite()) {
      for (int c = 0; c < Stream::kComponents; ++c)
        q.values[static_cast<size_t>(c)][k] = before != nullptr ? (*before)[static_cast<size_t>(c)][k] : 0;
      q.values[3][k] = Stream::kHidden;
      ++q.hidden;
      continue;
    }
    const Eigen::Vector3d moved = (frame.position(i) - g.position[i]).cast<double>();
    for (int c = 0; c < Stream::kComponents; ++c) {
      const double value = c < 3 ? moved[c] : frame.F(i)((c - 3) / 3, (c - 3) % 3) - ((c - 3) % 4 == 0 ? 1.0 : 0.0);
      const double step = c < 3 ? s.steps.position : s.steps.deformation;
      if (std::abs(value / step) > kRange + 0.5) ++q.cut;
      q.values[static_cast<size_t>(c)][k] = rounded(value, step, kRange);
    }
  }
  return q;
}

std::string frame_chunk(const FrameValues& values, const FrameValues* last, const FrameValues* last_but_one) {
  std::string chunk;
  for (size_t c = 0; c < values.size(); ++c) {
    append_plane(values[c],
                 {last != nullptr ? &(*last)[c] : nullptr, last_but_one != nullptr ? &(*last_but_one)[c] : nullptr},
                 chunk);
  }
  return chunk;
}

void append_chunk(Stream& stream, const std::string& packed) {
  stream.chunk_bytes.push_back(packed.size());
  stream.bytes += packed;
}

// Every frame that is a multiple of `stride`, and the last one.
std::vector<int> every(int stride, int frame_count) {
  std::vector<int> frames;
  for (int t = 0; t < frame_count; t += stride) frames.push_back(t);
  if (frames.back() != frame_count - 1) frames.push_back(frame_count - 1);
  return frames;
}

// Packs the frames behind the rest state; stops early above `limit` bytes, if that is not 0.
void pack_frames(Stream& stream, const Gaussians& gaussians, const std::function<splat::TransportedFrame(int)>& frame,
                 size_t limit) {
  std::vector<Quantised> window;  // the two frames before the batch, then the batch
  const int count = static_cast<int>(stream.frames.size());
  for (int first = 0; first < count; first += kFrameBatch) {
    if (window.size() > 2) window.erase(window.begin(), window.end() - 2);
    const size_t old = window.size();
    const int last = std::min(count, first + kFrameBatch);
    for (int t = first; t < last; ++t) {
      window.push_back(quantised(gaussians, frame(stream.frames[static_cast<size_t>(t)]), stream,
                                 window.empty() ? nullptr : &window.back().values));
      stream.cut += window.back().cut;
      stream.hidden += window.back().hidden;
    }
    std::vector<std::string> packed(window.size() - old);
#pragma omp parallel for schedule(dynamic)
    for (size_t b = old; b < window.size(); ++b) {
      packed[b - old] = deflated(frame_chunk(window[b].values, b >= 1 ? &window[b - 1].values : nullptr,
                                             b >= 2 ? &window[b - 2].values : nullptr));
    }
    for (const std::string& chunk : packed) append_chunk(stream, chunk);
    if (limit > 0 && stream.bytes.size() > limit) return;
  }
}

}  // namespace

Stream make_stream(const Gaussians& gaussians, const std::vector<int32_t>& row, int sh_degree, int frame_count,
                   const std::function<splat::TransportedFrame(int)>& frame, const StreamLimits& limits) {
  Stream rest;
  rest.kept = chosen_gaussians(gaussians, row, limits.gaussians);
  rest.sh_degree = std::min(gaussians.sh_degree, sh_degree);
  rest.steps = steps_of(gaussians);
  rest.origin = splat::middle_box(gaussians).center();
  if (!rest.origin.allFinite()) rest.origin.setZero();
  append_chunk(rest, deflated(rest_chunk(gaussians, row, rest)));
  const size_t most = std::max<size_t>(2, limits.gaussian_frames / std::max<size_t>(1, rest.kept.size()));
  int stride = 1;
  while (every(stride, frame_count).size() > most) ++stride;
  for (;; ++stride) {
    Stream stream = rest;
    stream.frames = every(stride, frame_count);
    const bool shortest = stream.frames.size() <= 2;
    pack_frames(stream, gaussians, frame, shortest ? 0 : limits.bytes);
    if (shortest || limits.bytes == 0 || stream.bytes.size() <= limits.bytes) return stream;
    // As many frames fit as they are on average large.
    const size_t packed = stream.chunk_bytes.size() - 1;
    const double mean = static_cast<double>(stream.bytes.size() - rest.bytes.size()) / static_cast<double>(packed);
    const double fit = (static_cast<double>(limits.bytes) - static_cast<double>(rest.bytes.size())) / mean;
    if (fit > 1) stride = std::max(stride, static_cast<int>(frame_count / fit));
  }
}

}  // namespace physmas::report
