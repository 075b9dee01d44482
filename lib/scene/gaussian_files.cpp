#include "scene/gaussian_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/zip_archive.h"
#include "scene/gaussian_readers.h"
#include "scene/gzip.h"

namespace fs = std::filesystem;

namespace physmas {
namespace {

constexpr size_t kSplatBytes = 32;
constexpr const char* kSogMeta = "meta.json";

// Without regard to case: files come from systems that have none.
bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         std::equal(ending.begin(), ending.end(), text.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

bool is_folder(const std::string& path) {
  std::error_code failure;
  return fs::is_directory(path, failure);
}

// The folder of a SOG scene that `path` means, itself or by its meta.json; empty when it means something else.
std::string sog_folder(const std::string& path) {
  if (is_folder(path)) return path;
  return fs::path(path).filename() == kSogMeta ? folder_of(path) : "";
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

// The files of a SOG folder by name, meta.json first.
std::vector<std::string> sog_names(const std::string& folder) {
  std::vector<std::string> names = {kSogMeta};
  for (const std::string& name : files_in(folder)) {
    if (ends_with(name, ".webp") || ends_with(name, ".png")) names.push_back(name);
  }
  return names;
}

Gaussians read_sog_folder(const std::string& path, const std::string& folder, GaussianNotes& notes) {
  std::error_code failure;
  if (!fs::exists(join_path(folder, kSogMeta), failure)) throw unread_folder(path, files_in(folder));
  uint64_t size = 0;
  for (const std::string& name : sog_names(folder)) size += regular_file_size(join_path(folder, name));
  const auto read = [&](const std::string& name) { return read_file(resolve_inside(folder, name, path, "meta.json")); };
  return read_sog(path, read, size, notes);
}

Gaussians read_archive(const std::string& path, const std::string& bytes, GaussianNotes& notes) {
  const ZipArchive archive(bytes, path);
  if (archive.names().count(kSogMeta) == 0)
    throw unread_archive(path, {archive.names().begin(), archive.names().end()});
  return read_sog(
      path, [&](const std::string& name) { return archive.read(name); }, bytes.size(), notes);
}

// What is within gzip. Room grows with what comes out, not with what a header promises; of an .spz, only what its
// header has room for is inflated.
std::string inflated(const std::string& path, const std::string& bytes) {
  constexpr size_t kSmall = size_t{64} << 20, kMaxRatio = 100;  // no file of floats is packed better
  GzipStream stream(path, bytes);
  std::string out(kSpzHeaderBytes, '\0');
  out.resize(stream.read(out.data(), out.size()));
  const bool spz = is_spz(out);
  const size_t most = spz ? spz_bytes(path, out, bytes.size()) : std::max(kSmall, kMaxRatio * bytes.size());
  for (size_t piece = size_t{1} << 20; out.size() < most; piece = std::min(2 * piece, size_t{1} << 28)) {
    const size_t before = out.size(), wanted = std::min(piece, most - before);
    out.resize(before + wanted);
    const size_t got = stream.read(&out[before], wanted);
    out.resize(before + got);
    if (got < wanted) return out;
  }
  if (!spz)
    throw invalid_input({path, "", fmt::format("more than {} bytes from {} within gzip", most, bytes.size()),
                         "a file of Gaussians", "unpack it with gunzip first"});
  return out;
}

Gaussians read_ply(const PlyFile& file, GaussianNotes& notes) {
  Gaussians g = is_compressed_ply(file) ? read_compressed_ply(file) : read_standard_ply(file, notes);
  follow_comments(file, g, notes);
  if (file.trailing() > 0) {
    notes.warnings.push_back(fmt::format(
        "{} bytes after the last row are left out; if colours or places are wrong, so is the header", file.trailing()));
  }
  return g;
}

constexpr const char* kPlyRow = "element vertex row";
constexpr const char* kGaussian = "Gaussian";

GaussianFile swept(const std::string& path, const char* unit, const ReadingOptions& options, bool strict,
                   GaussianFile file) {
  sweep_values(path, unit, options, strict, file);
  return file;
}

GaussianFile parsed(const std::string& path, const std::string& bytes, const ReadingOptions& options, bool strict) {
  GaussianFile file;
  const bool packed = GzipStream::is_gzip(bytes);
  const std::string inside = packed ? inflated(path, bytes) : "";
  const std::string& data = packed ? inside : bytes;
  // Within gzip the name is that of the file before it was packed.
  const std::string name = packed && ends_with(path, ".gz") ? path.substr(0, path.size() - 3) : path;
  if (PlyFile::is_ply(data)) {
    file.gaussians = read_ply(PlyFile(path, data), file.notes);
    return swept(path, kPlyRow, options, strict, std::move(file));
  }
  if (is_spz(data)) {
    file.gaussians = read_spz(path, data, packed ? bytes.size() : 0, file.notes);
  } else if (ZipArchive::is_zip(data)) {
    file.gaussians = read_archive(path, data, file.notes);
  } else if (ends_with(name, ".splat")) {
    file.gaussians = read_splat(path, data);
  } else {
    throw unread_container(name, data);
  }
  return swept(path, kGaussian, options, strict, std::move(file));
}

GaussianFile read_any(const std::string& path, const ReadingOptions& options, bool strict) {
  const std::string folder = sog_folder(path);
  if (!folder.empty()) {
    GaussianFile file;
    file.gaussians = read_sog_folder(path, folder, file.notes);
    return swept(path, kGaussian, options, strict, std::move(file));
  }
  const int descriptor = open_regular_file(path);
  std::string start(4, '\0');
  start.resize(static_cast<size_t>(std::max<ssize_t>(0, read(descriptor, start.data(), start.size()))));
  close(descriptor);
  if (!PlyFile::is_ply(start)) return parsed(path, read_file(path, kMaxGaussianBytes), options, strict);
  GaussianFile file;
  file.gaussians = read_ply(PlyFile(path, kMaxGaussianBytes), file.notes);
  return swept(path, kPlyRow, options, strict, std::move(file));
}

Gaussians without_notes(const std::string& path, GaussianFile file) {
  for (const std::string& warning : file.notes.warnings) log_warning(path + ": " + warning);
  return std::move(file.gaussians);
}

}  // namespace

Gaussians read_splat(const std::string& path, const std::string& bytes) {
  if (bytes.empty() || bytes.size() % kSplatBytes != 0) {
    throw invalid_input({path, "size", fmt::format("{} bytes", bytes.size()),
                         fmt::format("a multiple of {}, at least one Gaussian", kSplatBytes)});
  }
  Gaussians g;
  g.resize(bytes.size() / kSplatBytes, 0);
  for (size_t i = 0; i < g.size(); ++i) {
    const char* at = bytes.data() + i * kSplatBytes;
    float v[6];
    std::memcpy(v, at, sizeof(v));
    const auto* b = reinterpret_cast<const unsigned char*>(at + sizeof(v));
    g.position[i] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
      if (!(v[3 + a] >= 0) || !std::isfinite(v[3 + a])) {
        throw invalid_input({path, fmt::format("Gaussian {} scale_{} (byte {})", i, a, i * kSplatBytes + 12 + 4 * a),
                             fmt::format("{}", v[3 + a]), "a finite number, 0 or more"});
      }
      // A flat Gaussian has scale 0, whose logarithm is not finite.
      g.log_scale[i][a] = std::log(std::max(v[3 + a], std::numeric_limits<float>::min()));
      g.sh[i][a] = sh_of_color(b[a] / 255.0);
    }
    g.opacity_logit[i] = opacity_logit_of(b[3] / 255.0);
    for (int k = 0; k < 4; ++k) g.rotation[i][k] = (static_cast<float>(b[4 + k]) - 128) / 128;
  }
  return g;
}

GaussianFile parse_gaussian_file(const std::string& path, const std::string& bytes, const ReadingOptions& options) {
  return parsed(path, bytes, options, false);
}

GaussianFile read_gaussian_file(const std::string& path, const ReadingOptions& options) {
  return read_any(path, options, false);
}

std::vector<std::string> gaussian_input_files(const std::string& path) {
  const std::string folder = sog_folder(path);
  if (folder.empty()) return {path};
  std::vector<std::string> files;
  for (const std::string& name : sog_names(folder)) files.push_back(join_path(folder, name));
  return files;
}

Gaussians parse_gaussians(const std::string& path, const std::string& bytes) {
  return without_notes(path, parsed(path, bytes, {}, true));
}

Gaussians load_gaussians(const std::string& path) {
  return without_notes(path, read_any(path, {}, true));
}

Gaussians load_labelled_gaussians(const std::string& path, const State& state, const std::string& state_path) {
  Gaussians gaussians = load_gaussians(path);
  if (state.gaussian_count() != gaussians.size()) {
    throw invalid_input({state_path, "/gaussians/row", std::to_string(state.gaussian_count()) + " Gaussians",
                         "the " + std::to_string(gaussians.size()) + " of " + path,
                         "make the state again with pm-lift"});
  }
  return gaussians;
}

}  // namespace physmas
