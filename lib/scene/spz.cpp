#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr size_t kHeaderBytes = 16;
constexpr uint32_t kMagic = 0x5053474e;  // "NGSP"
// As Niantic's own reader has it.
constexpr uint32_t kMaxGaussians = 10000000;
// Deflate cannot shrink further (zlib's technical notes: 1032 : 1), so a file that promises more lies.
constexpr size_t kMaxRatio = 1032;
constexpr uint8_t kHasExtensions = 2;  // bit of `flags`: records that we do not know follow the Gaussians
constexpr double kColorScale = 0.15;

uint32_t word_at(const unsigned char* p) {
  return p[0] | p[1] << 8 | p[2] << 16 | static_cast<uint32_t>(p[3]) << 24;
}

// A gzip stream that is inflated piece by piece, each into room that the caller knows to be needed.
class GzipStream {
 public:
  GzipStream(const std::string& path, const std::string& bytes) : path_(path) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    left_ = bytes.size();
    constexpr int kGzipWindow = 15 + 16;
    if (inflateInit2(&stream_, kGzipWindow) != Z_OK) throw internal_error("zlib could not be started");
  }
  ~GzipStream() { inflateEnd(&stream_); }
  GzipStream(const GzipStream&) = delete;
  GzipStream& operator=(const GzipStream&) = delete;

  // Up to `size` bytes; fewer only at the end of the stream, whose checksum is then verified.
  size_t read(unsigned char* out, size_t size) {
    size_t done = 0;
    while (done < size && !ended_) {
      constexpr size_t kPiece = size_t{1} << 30;  // zlib counts in 32 bits
      const size_t room = std::min(size - done, kPiece), input = std::min(left_, kPiece);
      stream_.next_out = out + done;
      stream_.avail_out = static_cast<uInt>(room);
      stream_.avail_in = static_cast<uInt>(input);
      const int status = inflate(&stream_, Z_NO_FLUSH);
      left_ -= input - stream_.avail_in;
      done += room - stream_.avail_out;
      total_ += room - stream_.avail_out;
      ended_ = status == Z_STREAM_END;
      if (status == Z_OK || ended_) continue;
      const bool starved = status == Z_BUF_ERROR && left_ == 0;
      throw invalid_input({path_, fmt::format("byte {} of the inflated stream", total_),
                           starved ? "the end of the file" : "damaged gzip data", "a whole gzip stream",
                           "the file may be cut off"});
    }
    return done;
  }

 private:
  std::string path_;
  z_stream stream_ = {};
  size_t left_ = 0, total_ = 0;
  bool ended_ = false;
};

// Version 3: the two top bits name the largest of x, y, z, w; the others follow from the first to the last with a
// sign and nine bits of magnitude up to 1/sqrt(2) each.
std::array<float, 4> unpack_smallest_three(uint32_t word) {
  const int largest = static_cast<int>(word >> 30);
  double q[4], squared = 0;
  int shift = 20;
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const uint32_t bits = word >> shift & 0x3ff;
    q[k] = std::sqrt(0.5) * (bits & 0x1ff) / 511 * (bits & 0x200 ? -1 : 1);
    squared += q[k] * q[k];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(0.0, 1 - squared));
  return {static_cast<float>(q[3]), static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2])};
}

// Version 2: x, y, z as bytes over -1..1; w is what is missing to length 1, and not negative.
std::array<float, 4> unpack_first_three(const unsigned char* p) {
  double q[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    q[k] = p[k] / 127.5 - 1;
    squared += q[k] * q[k];
  }
  return {static_cast<float>(std::sqrt(std::max(0.0, 1 - squared))), static_cast<float>(q[0]), static_cast<float>(q[1]),
          static_cast<float>(q[2])};
}

// Three bytes, two's complement.
double fixed_point(const unsigned char* p, int fractional_bits) {
  const uint32_t bits = p[0] | p[1] << 8 | p[2] << 16;
  const double value = static_cast<double>(bits) - (bits & 0x800000 ? 0x1000000 : 0);
  return std::ldexp(value, -fractional_bits);
}

}  // namespace

bool is_spz(const std::string& bytes) {
  const bool gzip = bytes.compare(0, 2, "\x1f\x8b") == 0;
  return gzip || bytes.compare(0, 4, "NGSP") == 0;
}

Gaussians read_spz(const std::string& path, const std::string& bytes) {
  if (bytes.compare(0, 4, "NGSP") == 0) {
    throw invalid_input({path, "byte 0", "an .spz file without gzip around it (version 4 or later)",
                         "version 2 or 3, a gzip stream", "save it again as version 3, or as .ply"});
  }
  GzipStream stream(path, bytes);
  unsigned char header[kHeaderBytes];
  const size_t got = stream.read(header, kHeaderBytes);
  if (got < kHeaderBytes || word_at(header) != kMagic) {
    throw invalid_input({path, "header", got < kHeaderBytes ? fmt::format("{} bytes", got) : "another gzip file",
                         "the 16 bytes of an .spz header, which start with NGSP"});
  }
  const uint32_t version = word_at(header + 4), count = word_at(header + 8);
  const int degree = header[12], fractional_bits = header[13];
  const auto refuse = [&](const char* field, const std::string& found, const std::string& expected) {
    return invalid_input({path, std::string("header ") + field, found, expected});
  };
  if (version != 2 && version != 3) throw refuse("version", std::to_string(version), "2 or 3");
  if (degree > 3) throw refuse("shDegree", std::to_string(degree), "0 to 3");
  if (fractional_bits > 23) throw refuse("fractionalBits", std::to_string(fractional_bits), "0 to 23");
  if (count == 0 || count > kMaxGaussians) {
    throw refuse("numPoints", std::to_string(count), fmt::format("1 to {} Gaussians", kMaxGaussians));
  }
  const int rest = sh_coefficient_count(degree) - 1;
  const size_t rotation_bytes = version == 2 ? 3 : 4;
  const size_t each = 9 + 1 + 3 + 3 + rotation_bytes + 3 * rest, size = count * each;
  if (size > bytes.size() * kMaxRatio) {
    throw refuse(
        "numPoints", std::to_string(count),
        fmt::format("at most the {} that {} compressed bytes can hold", bytes.size() * kMaxRatio / each, bytes.size()));
  }
  std::vector<unsigned char> body(size);
  const size_t filled = stream.read(body.data(), size);
  if (filled < size) {
    throw invalid_input({path, "body", fmt::format("{} bytes", filled),
                         fmt::format("{} for {} Gaussians of {} bytes", size, count, each)});
  }
  unsigned char beyond;
  if ((header[14] & kHasExtensions) == 0 && stream.read(&beyond, 1) != 0) {
    throw invalid_input({path, "body", fmt::format("more than {} bytes", size),
                         fmt::format("the end after {} Gaussians of {} bytes", count, each)});
  }

  // One array after the other: positions, opacities, colours, scales, rotations, harmonics.
  const unsigned char* positions = body.data();
  const unsigned char* opacities = positions + size_t{9} * count;
  const unsigned char* colors = opacities + count;
  const unsigned char* scales = colors + size_t{3} * count;
  const unsigned char* rotations = scales + size_t{3} * count;
  const unsigned char* harmonics = rotations + rotation_bytes * count;
  Gaussians g;
  g.resize(count, degree);
  for (size_t i = 0; i < count; ++i) {
    Eigen::Vector3f* sh = &g.sh[i * (rest + 1)];
    for (int a = 0; a < 3; ++a) {
      g.position[i][a] = static_cast<float>(fixed_point(positions + 9 * i + 3 * a, fractional_bits));
      g.log_scale[i][a] = scales[3 * i + a] / 16.0f - 10;
      sh[0][a] = static_cast<float>((colors[3 * i + a] / 255.0 - 0.5) / kColorScale);
    }
    g.opacity_logit[i] = opacity_logit_of_byte(opacities[i]);
    const unsigned char* q = rotations + rotation_bytes * i;
    g.rotation[i] = version == 2 ? unpack_first_three(q) : unpack_smallest_three(word_at(q));
    for (int k = 0; k < rest; ++k) {
      for (int c = 0; c < 3; ++c) sh[k + 1][c] = (harmonics[3 * (rest * i + k) + c] - 128) / 128.0f;
    }
  }
  return g;
}

}  // namespace physmas
