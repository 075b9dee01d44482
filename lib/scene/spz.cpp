#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

constexpr size_t kHeaderBytes = kSpzHeaderBytes, kLongHeaderBytes = 32;
constexpr size_t kMaxExtensions = 1 << 16;  // bytes
// As Niantic's own reader has it.
constexpr uint32_t kMaxGaussians = 10000000;
// Deflate cannot shrink further (zlib's technical notes: 1032 : 1), and no captured scene comes near it with zstd.
constexpr size_t kMaxRatio = 1032;
constexpr uint8_t kHasExtensions = 2;               // a bit of `flags`
constexpr uint32_t kCoordinateSystem = 0xadbe0003;  // a type of extension
constexpr uint32_t kRightUpBack = 4;                // the coordinate system of files that say none

uint32_t word_at(const unsigned char* p) {
  return p[0] | p[1] << 8 | p[2] << 16 | static_cast<uint32_t>(p[3]) << 24;
}

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

// IEEE 754 half.
double half_at(const unsigned char* p) {
  const uint32_t bits = p[0] | p[1] << 8, exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double sign = bits & 0x8000 ? -1 : 1;
  if (exponent == 31) return fraction != 0 ? NAN : sign * INFINITY;
  return sign *
         (exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(fraction + 1024, static_cast<int>(exponent) - 25));
}

struct Header {
  uint32_t version = 0, count = 0;
  int degree = 0, fractional_bits = 0;
  uint8_t flags = 0;
  size_t position_bytes() const { return version == 1 ? 6 : 9; }
  size_t rotation_bytes() const { return version < 3 ? 3 : 4; }
  size_t harmonic_bytes() const { return 3 * static_cast<size_t>((degree + 1) * (degree + 1) - 1); }
  // Positions, opacities, colours, scales, rotations, harmonics, in this order.
  std::array<size_t, 6> sizes() const {
    const size_t n = count;
    return {n * position_bytes(), n, 3 * n, 3 * n, n * rotation_bytes(), n * harmonic_bytes()};
  }
  size_t each() const { return position_bytes() + 7 + rotation_bytes() + harmonic_bytes(); }
};

Error refused(const std::string& path, const char* field, const std::string& found, const std::string& expected) {
  return invalid_input({path, std::string("header ") + field, found, expected});
}

// The first 16 bytes of every version. packed: size of the file, which bounds the number of Gaussians.
Header header_from(const std::string& path, const unsigned char* bytes, size_t packed) {
  Header h;
  h.version = word_at(bytes + 4), h.count = word_at(bytes + 8);
  h.degree = bytes[12], h.fractional_bits = bytes[13], h.flags = bytes[14];
  if (h.version < 1 || h.version > 4) throw refused(path, "version", std::to_string(h.version), "1 to 4");
  if (h.degree > 4) throw refused(path, "shDegree", std::to_string(h.degree), "0 to 4");
  if (h.fractional_bits > 23) throw refused(path, "fractionalBits", std::to_string(h.fractional_bits), "0 to 23");
  if (h.count == 0 || h.count > kMaxGaussians)
    throw refused(path, "numPoints", std::to_string(h.count), fmt::format("1 to {} Gaussians", kMaxGaussians));
  const size_t most = packed * kMaxRatio / h.each();
  if (h.count > most) {
    throw refused(path, "numPoints", std::to_string(h.count),
                  fmt::format("at most the {} that {} compressed bytes can hold", most, packed));
  }
  return h;
}

// Records of vendors: type, length, payload. Adobe's coordinate system is followed, others are passed over.
uint32_t coordinate_system(const std::string& path, const std::string& records) {
  uint32_t system = kRightUpBack;
  for (size_t at = 0; at < records.size();) {
    const auto* p = reinterpret_cast<const unsigned char*>(records.data()) + at;
    const size_t left = records.size() - at;
    if (left < 8 || word_at(p + 4) > left - 8) {
      throw invalid_input({path, fmt::format("extension at byte {}", at), fmt::format("{} bytes", left),
                           left < 8 ? "a type and a length" : fmt::format("{} bytes of payload", word_at(p + 4))});
    }
    if (word_at(p) == kCoordinateSystem && word_at(p + 4) == 4) system = word_at(p + 8);
    at += 8 + word_at(p + 4);
  }
  return system;
}

// Left or right, up or down, front or back: along which x, y and z point.
void follow_coordinates(uint32_t system, Gaussians& g, GaussianNotes& notes) {
  struct System {
    const char* name;
    const char* up;
    bool left_handed;
  };
  static constexpr System kSystems[] = {
      {"", "y", false},    {"LDB", "-y", false}, {"RDB", "-y", true}, {"LUB", "y", true},  {"RUB", "y", false},
      {"LDF", "-y", true}, {"RDF", "-y", false}, {"LUF", "y", false}, {"RUF", "y", true},  {"LFD", "-z", false},
      {"RFD", "-z", true}, {"LFU", "z", true},   {"RFU", "z", false}, {"LBD", "-z", true}, {"RBD", "-z", false},
      {"LBU", "z", false}, {"RBU", "z", true}};
  if (system >= std::size(kSystems)) {
    notes.warnings.push_back(fmt::format("coordinate system {} is unknown, y is taken as up", system));
    notes.up = "y";
    return;
  }
  const System& s = kSystems[system];
  notes.up = s.up;
  if (system == 0 || system == kRightUpBack) return;
  if (s.left_handed) mirror_z(g);
  const std::string up = s.left_handed && s.up[std::strlen(s.up) - 1] == 'z' ? (s.up[0] == '-' ? "z" : "-z") : s.up;
  notes.up = up;
  notes.notes.push_back(fmt::format("its coordinate system is {}: {} is taken as up{}", s.name, up,
                                    s.left_handed ? ", and z is mirrored to make it right-handed" : ""));
}

// arrays: pointers to the six arrays.
Gaussians unpacked(const Header& h, const std::array<const unsigned char*, 6>& arrays) {
  const auto& [positions, opacities, colors, scales, rotations, harmonics] = arrays;
  Gaussians g;
  const int degree = std::min(h.degree, 3), rest = sh_coefficient_count(degree) - 1;
  g.resize(h.count, degree);
  g.antialiased = (h.flags & kSpzAntialiased) != 0;
  for (size_t i = 0; i < h.count; ++i) {
    Eigen::Vector3f* sh = &g.sh[i * (rest + 1)];
    for (int a = 0; a < 3; ++a) {
      const size_t value = 3 * i + a;
      g.position[i][a] = static_cast<float>(h.version == 1 ? half_at(positions + 2 * value)
                                                           : fixed_point(positions + 3 * value, h.fractional_bits));
      g.log_scale[i][a] = scales[value] / 16.0f - 10;
      sh[0][a] = static_cast<float>((colors[value] / 255.0 - 0.5) / kSpzColorScale);
    }
    g.opacity_logit[i] = opacity_logit_of(opacities[i] / 255.0);
    const unsigned char* q = rotations + h.rotation_bytes() * i;
    g.rotation[i] = h.version < 3 ? unpack_first_three(q) : unpack_smallest_three(word_at(q));
    for (int k = 0; k < rest; ++k) {
      for (int c = 0; c < 3; ++c) sh[k + 1][c] = (harmonics[h.harmonic_bytes() * i + 3 * k + c] - 128) / 128.0f;
    }
  }
  return g;
}

// Versions 1 to 3, the bytes that were within gzip; `extensions` is what follows the arrays.
Gaussians read_whole(const std::string& path, const Header& h, const std::string& bytes, std::string& extensions) {
  const size_t size = h.count * h.each(), got = bytes.size() - kHeaderBytes;
  if (got < size) {
    throw invalid_input({path, "body", fmt::format("{} bytes", got),
                         fmt::format("{} for {} Gaussians of {} bytes", size, h.count, h.each())});
  }
  if ((h.flags & kHasExtensions) == 0 && got > size) {
    throw invalid_input({path, "body", fmt::format("more than {} bytes", size),
                         fmt::format("the end after {} Gaussians of {} bytes", h.count, h.each())});
  }
  extensions = bytes.substr(kHeaderBytes + size);
  std::array<const unsigned char*, 6> arrays;
  const auto* at = reinterpret_cast<const unsigned char*>(bytes.data()) + kHeaderBytes;
  const std::array<size_t, 6> sizes = h.sizes();
  for (size_t k = 0; k < arrays.size(); ++k) {
    arrays[k] = at;
    at += sizes[k];
  }
  return unpacked(h, arrays);
}

// Version 4: a stream of zstd for each array; one without bytes may be left out.
Gaussians read_streams(const std::string& path, const Header& h, const std::string& bytes, std::string& extensions) {
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const size_t streams = data[15], table = word_at(data + 16);
  const std::array<size_t, 6> sizes = h.sizes();
  const size_t filled = 6 - (sizes[5] == 0);
  if (streams != 6 && streams != filled)
    throw refused(path, "numStreams", std::to_string(streams), fmt::format("{} or 6", filled));
  if (table < kLongHeaderBytes || table > bytes.size() || bytes.size() - table < 16 * streams) {
    throw refused(path, "tocByteOffset", std::to_string(table),
                  fmt::format("a table of {} streams inside the file, after byte {}", streams, kLongHeaderBytes));
  }
  if ((h.flags & kHasExtensions) != 0) extensions = bytes.substr(kLongHeaderBytes, table - kLongHeaderBytes);
  std::array<std::string, 6> arrays;
  std::array<const unsigned char*, 6> starts = {};
  size_t at = table + 16 * streams;
  for (size_t k = 0; k < streams; ++k) {
    const auto number = [&](size_t place) {
      return word_at(data + place) | static_cast<uint64_t>(word_at(data + place + 4)) << 32;
    };
    const uint64_t packed = number(table + 16 * k), size = number(table + 16 * k + 8);
    const auto bad = [&](const std::string& found, const std::string& expected) {
      return invalid_input({path, fmt::format("stream {} of the table at byte {}", k, table), found, expected});
    };
    if (size != sizes[k]) throw bad(fmt::format("{} bytes", size), fmt::format("{}", sizes[k]));
    if (packed > bytes.size() - at)
      throw bad(fmt::format("{} compressed bytes", packed), fmt::format("the {} that are left", bytes.size() - at));
    arrays[k].resize(size);
    const size_t got = ZSTD_decompress(arrays[k].data(), size, bytes.data() + at, packed);
    if (ZSTD_isError(got) || got != size)
      throw bad(ZSTD_isError(got) ? ZSTD_getErrorName(got) : fmt::format("{} bytes", got),
                fmt::format("a whole zstd stream of {} bytes", size));
    starts[k] = reinterpret_cast<const unsigned char*>(arrays[k].data());
    at += packed;
  }
  if (at != bytes.size())
    throw invalid_input({path, fmt::format("byte {}", at), fmt::format("{} more bytes", bytes.size() - at),
                         "the end of the file after the last stream"});
  return unpacked(h, starts);
}

}  // namespace

bool is_spz(const std::string& bytes) {
  return bytes.compare(0, 4, "NGSP") == 0;
}

size_t spz_bytes(const std::string& path, const std::string& header, size_t packed) {
  if (header.size() < kHeaderBytes) return kHeaderBytes;
  const Header h = header_from(path, reinterpret_cast<const unsigned char*>(header.data()), packed);
  if (h.version == 4) return packed * kMaxRatio;
  // One byte more tells a file that is too long.
  return kHeaderBytes + h.count * h.each() + ((h.flags & kHasExtensions) != 0 ? kMaxExtensions : 1);
}

Gaussians read_spz(const std::string& path, const std::string& bytes, size_t packed, GaussianNotes& notes) {
  if (bytes.size() < kHeaderBytes)
    throw invalid_input({path, "header", fmt::format("{} bytes", bytes.size()), "the 16 bytes of an .spz header"});
  const Header h =
      header_from(path, reinterpret_cast<const unsigned char*>(bytes.data()), packed > 0 ? packed : bytes.size());
  if (h.version < 4 && packed == 0)
    throw refused(path, "version", fmt::format("{} without gzip around it", h.version), "version 4");
  if (h.version == 4 && bytes.size() < kLongHeaderBytes)
    throw invalid_input({path, "header", fmt::format("{} bytes", bytes.size()), "the 32 bytes of version 4"});
  std::string extensions;
  Gaussians g = h.version == 4 ? read_streams(path, h, bytes, extensions) : read_whole(path, h, bytes, extensions);
  follow_coordinates(coordinate_system(path, extensions), g, notes);
  if (h.degree > 3) notes.notes.push_back("harmonics of degree 4 are left out: degrees 0 to 3 are drawn");
  if (g.antialiased) notes.notes.push_back("trained with anti-aliasing: opacities are compensated as in training");
  return g;
}

}  // namespace physmas
