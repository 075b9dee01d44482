#include "splat/npz_motion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include <cmath>

#include "base/error.h"

namespace physmas::splat {
namespace {

void put(std::string& bytes, uint64_t value, int count) {
  for (int k = 0; k < count; ++k) bytes += static_cast<char>(value >> 8 * k & 255);
}

// The head of an .npy file of version 1.
std::string npy_head(const char* type, const std::vector<size_t>& shape) {
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({},), }}", type, fmt::join(shape, ", "));
  // The data are to lie on lines of 64 bytes.
  text.resize((10 + text.size() + 1 + 63) / 64 * 64 - 11, ' ');
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  put(head, text.size(), 2);
  return head + text;
}

constexpr uint64_t kLarge = 0xffffffff;  // the size stands in a field of 64 bits

// What both heads of an entry share, stored, without a time.
std::string common(uint32_t crc, const std::string& name, size_t extra) {
  std::string bytes;
  put(bytes, 45, 2);  // the version that reads 64-bit sizes
  put(bytes, 0, 2);
  put(bytes, 0, 2);
  put(bytes, 0, 2);
  put(bytes, 0x21, 2);  // 1980-01-01
  put(bytes, crc, 4);
  put(bytes, kLarge, 4);
  put(bytes, kLarge, 4);
  put(bytes, name.size(), 2);
  put(bytes, extra, 2);
  return bytes;
}

std::string local_head(uint32_t crc, const std::string& name, uint64_t size) {
  std::string bytes("PK\x03\x04", 4);
  bytes += common(crc, name, 20) + name;
  put(bytes, 1, 2);
  put(bytes, 16, 2);
  put(bytes, size, 8);
  put(bytes, size, 8);
  return bytes;
}

}  // namespace

NpzMotion::NpzMotion(const std::string& path, size_t frames, const Gaussians& rest, const std::vector<int32_t>& rows)
    : file_(path), frames_(frames) {
  const size_t n = rest.size(), k = sh_coefficient_count(rest.sh_degree);
  begin("positions", "<f4", {frames, n, 3}, 4);
  begin("rotations", "<f4", {frames, n, 4}, 4);
  begin("scales", "<f4", {frames, n, 3}, 4);
  begin("times", "<f8", {frames}, 8);
  begin("frames", "<i4", {frames}, 4);
  std::vector<float> opacities(n);
  for (size_t i = 0; i < n; ++i) opacities[i] = rest.opacity(i);
  fill(begin("opacities", "<f4", {n}, 4), opacities.data(), 4 * n);
  fill(begin("harmonics", "<f4", {n, k, 3}, 4), rest.sh.data(), sizeof(Eigen::Vector3f) * n * k);
  fill(begin("rows", "<i4", {n}, 4), rows.data(), 4 * n);
}

NpzMotion::Entry& NpzMotion::begin(const std::string& name, const char* type, const std::vector<size_t>& shape,
                                   size_t element_bytes) {
  Entry entry;
  entry.name = name + ".npy";
  const std::string head = npy_head(type, shape);
  uint64_t data = element_bytes;
  for (const size_t length : shape) data *= length;
  entry.size = head.size() + data;
  entry.local = file_.written();
  file_.write(local_head(0, entry.name, entry.size));
  entry.data = file_.written();
  file_.skip(entry.size);
  entries_.push_back(entry);
  fill(entries_.back(), head.data(), head.size());
  return entries_.back();
}

void NpzMotion::fill(Entry& entry, const void* bytes, size_t count) {
  if (entry.filled + count > entry.size) throw internal_error("more frames than an array has room for");
  file_.overwrite(entry.data + entry.filled, bytes, count);
  entry.filled += count;
  const auto* at = static_cast<const Bytef*>(bytes);
  for (size_t done = 0; done < count;) {
    const size_t piece = std::min<size_t>(count - done, size_t{1} << 30);
    entry.crc = static_cast<uint32_t>(crc32(entry.crc, at + done, static_cast<uInt>(piece)));
    done += piece;
  }
}

void NpzMotion::add(int frame, double time, const Gaussians& g) {
  std::vector<std::array<float, 4>> rotations(g.size());
  std::vector<Eigen::Vector3f> scales(g.size());
  for (size_t i = 0; i < g.size(); ++i) {
    double norm = 0;
    for (const float v : g.rotation[i]) norm += double(v) * v;
    for (int c = 0; c < 4; ++c) rotations[i][c] = static_cast<float>(g.rotation[i][c] / std::sqrt(norm));
    scales[i] = g.scale(i);
  }
  const int32_t number = frame;
  fill(entries_[0], g.position.data(), sizeof(Eigen::Vector3f) * g.size());
  fill(entries_[1], rotations.data(), sizeof(rotations[0]) * g.size());
  fill(entries_[2], scales.data(), sizeof(Eigen::Vector3f) * g.size());
  fill(entries_[3], &time, sizeof(time));
  fill(entries_[4], &number, sizeof(number));
}

bool NpzMotion::commit() {
  std::string directory;
  for (const Entry& entry : entries_) {
    if (entry.filled != entry.size) throw internal_error("an array with fewer frames than it has room for");
    const std::string head = local_head(entry.crc, entry.name, entry.size);
    file_.overwrite(entry.local, head.data(), head.size());
    directory += std::string("PK\x01\x02", 4);
    put(directory, 45, 2);
    directory += common(entry.crc, entry.name, 28);
    put(directory, 0, 2 + 2 + 2 + 4);
    put(directory, kLarge, 4);
    directory += entry.name;
    put(directory, 1, 2);
    put(directory, 24, 2);
    for (const uint64_t value : {entry.size, entry.size, entry.local}) put(directory, value, 8);
  }
  const uint64_t start = file_.written();
  file_.write(directory);
  const uint64_t end = file_.written();
  std::string tail("PK\x06\x06", 4);
  put(tail, 44, 8);
  put(tail, 45, 2);
  put(tail, 45, 2);
  put(tail, 0, 8);
  put(tail, entries_.size(), 8);
  put(tail, entries_.size(), 8);
  put(tail, directory.size(), 8);
  put(tail, start, 8);
  tail += std::string("PK\x06\x07", 4);
  put(tail, 0, 4);
  put(tail, end, 8);
  put(tail, 1, 4);
  tail += std::string("PK\x05\x06", 4);
  put(tail, 0, 4);
  put(tail, entries_.size(), 2);
  put(tail, entries_.size(), 2);
  put(tail, kLarge, 4);
  put(tail, kLarge, 4);
  put(tail, 0, 2);
  file_.write(tail);
  return file_.commit();
}

}  // namespace physmas::splat
