#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "records/json.h"
#include "scene/gaussian_readers.h"
#include "scene/image_file.h"

namespace physmas {
namespace {

// Deflate's ratio: no image of captured values comes near it.
constexpr uint64_t kMaxRatio = 1032;
constexpr uint64_t kMaxGaussians = 10000000, kMaxPalette = 65536;
constexpr int kPaletteColumns = 64;

class Meta {
 public:
  Meta(const std::string& path, const SogFiles& read) : path_(path), json_(parse_json(read("meta.json"), path)) {
    if (!json_.is_object()) throw invalid_field(path_, "/", json_, "an object");
  }

  const Json* find(const std::string& pointer) const {
    const Json::json_pointer place(pointer);
    return json_.contains(place) ? &json_.at(place) : nullptr;
  }
  bool has(const std::string& pointer) const { return find(pointer) != nullptr && !find(pointer)->is_null(); }

  uint64_t integer(const std::string& pointer, uint64_t least, uint64_t most) const {
    const Json& value = at(pointer);
    const bool whole = value.is_number_integer() && value >= least && value <= most;
    if (!whole) throw error(pointer, fmt::format("{} to {}", least, most));
    return value.get<uint64_t>();
  }

  std::vector<double> numbers(const std::string& pointer, size_t count) const {
    const Json& value = at(pointer);
    const std::string expected = fmt::format("a list of {} finite numbers", count);
    if (!value.is_array() || value.size() != count) throw error(pointer, expected);
    std::vector<double> out;
    for (const Json& entry : value) {
      if (!entry.is_number() || !std::isfinite(entry.get<double>())) throw error(pointer, expected);
      out.push_back(entry.get<double>());
    }
    return out;
  }

  // A file's name: it lies beside meta.json.
  std::string file(const std::string& pointer) const {
    const Json& value = at(pointer);
    const std::string name = value.is_string() ? value.get<std::string>() : "";
    if (name.empty() || name.find_first_of("/\\") != std::string::npos || name[0] == '.' ||
        name.find('\0') != std::string::npos)
      throw error(pointer, "the name of a file beside meta.json");
    return name;
  }

  Error error(const std::string& pointer, const std::string& expected) const {
    const Json* value = find(pointer);
    if (value == nullptr) return invalid_input({path_, "meta.json " + pointer, "nothing", expected});
    return invalid_field(path_, "meta.json " + pointer, *value, expected);
  }

 private:
  const Json& at(const std::string& pointer) const {
    const Json* value = find(pointer);
    if (value == nullptr) throw error(pointer, "a value");
    return *value;
  }

  std::string path_;
  Json json_;
};

// sign(v) (exp(|v|) - 1): positions are stored as the inverse of it.
float stretched(double v) {
  return static_cast<float>(std::copysign(std::expm1(std::abs(v)), v));
}

// The last byte, 252 to 255, names the component of w, x, y, z that is left out, the largest; it is positive.
std::array<float, 4> rotation_from(const uint8_t* rgba) {
  const int largest = rgba[3] - 252;
  if (largest < 0) return {1, 0, 0, 0};
  std::array<float, 4> q = {};
  double rest = 1;
  int next = 0;
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const double value = (rgba[next++] / 255.0 * 2 - 1) / std::sqrt(2.0);
    q[k] = static_cast<float>(value);
    rest -= value * value;
  }
  q[largest] = static_cast<float>(std::sqrt(std::max(0.0, rest)));
  return q;
}

}  // namespace

Gaussians read_sog(const std::string& path, const SogFiles& read, uint64_t size, GaussianNotes& notes) {
  const Meta meta(path, read);
  if (!meta.has("/version"))
    throw invalid_input(
        {path, "meta.json /version", "nothing: SOG of version 1", "version 2", "convert it with splat-transform"});
  meta.integer("/version", 2, 2);
  const uint64_t count = meta.integer("/count", 1, std::min(kMaxGaussians, size * kMaxRatio));
  const auto image = [&](const std::string& pointer, uint64_t least, uint64_t most) {
    const std::string name = meta.file(pointer), where = path + ": " + name;
    Image picture = decode_rgba(read(name), where, most);
    const uint64_t pixels = static_cast<uint64_t>(picture.width) * picture.height;
    if (pixels < least)
      throw invalid_input({where, "", fmt::format("{} pixels", pixels), fmt::format("{} or more", least)});
    return picture;
  };
  const auto of_each = [&](const std::string& pointer) { return image(pointer, count, 4 * count + 65536); };

  Gaussians g;
  int degree = 0;
  if (meta.has("/shN")) degree = static_cast<int>(meta.integer("/shN/bands", 0, 3));
  const int rest = sh_coefficient_count(degree) - 1;
  g.resize(count, degree);
  {
    const std::vector<double> low = meta.numbers("/means/mins", 3), high = meta.numbers("/means/maxs", 3);
    const Image lower = of_each("/means/files/0"), upper = of_each("/means/files/1");
    for (size_t i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) {
        const int level = lower.pixels[4 * i + a] | upper.pixels[4 * i + a] << 8;
        g.position[i][a] = stretched(low[a] + (high[a] - low[a]) * level / 65535);
      }
    }
  }
  {
    const std::vector<double> codes = meta.numbers("/scales/codebook", 256);
    const Image levels = of_each("/scales/files/0");
    for (size_t i = 0; i < count; ++i) {
      for (int a = 0; a < 3; ++a) g.log_scale[i][a] = static_cast<float>(codes[levels.pixels[4 * i + a]]);
    }
  }
  {
    const Image levels = of_each("/quats/files/0");
    for (size_t i = 0; i < count; ++i) g.rotation[i] = rotation_from(&levels.pixels[4 * i]);
  }
  {
    const std::vector<double> codes = meta.numbers("/sh0/codebook", 256);
    const Image levels = of_each("/sh0/files/0");
    for (size_t i = 0; i < count; ++i) {
      for (int c = 0; c < 3; ++c) g.sh[i * (rest + 1)][c] = static_cast<float>(codes[levels.pixels[4 * i + c]]);
      g.opacity_logit[i] = opacity_logit_of(levels.pixels[4 * i + 3] / 255.0);
    }
  }
  if (degree > 0) {
    const uint64_t entries = meta.integer("/shN/count", 1, kMaxPalette);
    const std::vector<double> codes = meta.numbers("/shN/codebook", 256);
    const uint64_t rows = (entries + kPaletteColumns - 1) / kPaletteColumns;
    const uint64_t width = static_cast<uint64_t>(kPaletteColumns) * rest;
    const Image palette = image("/shN/files/0", rows * width, 2 * rows * width + 65536);
    if (static_cast<uint64_t>(palette.width) != width)
      throw invalid_input({path, "meta.json /shN/files/0", fmt::format("a picture of {} columns", palette.width),
                           fmt::format("{}, {} for each of {} entries", width, rest, kPaletteColumns)});
    const Image labels = of_each("/shN/files/1");
    for (size_t i = 0; i < count; ++i) {
      const uint64_t label = labels.pixels[4 * i] | static_cast<uint64_t>(labels.pixels[4 * i + 1]) << 8;
      if (label >= entries) continue;  // none: its harmonics stay zero
      const size_t first = (label / kPaletteColumns) * width + (label % kPaletteColumns) * rest;
      for (int k = 0; k < rest; ++k) {
        for (int c = 0; c < 3; ++c)
          g.sh[i * (rest + 1) + 1 + k][c] = static_cast<float>(codes[palette.pixels[4 * (first + k) + c]]);
      }
    }
  }
  const Json *model = meta.find("/model"), *flag = meta.find("/antialias");
  g.antialiased = (model != nullptr && *model == "antialiased") || (flag != nullptr && *flag == true);
  if (g.antialiased) notes.notes.push_back("trained with anti-aliasing: opacities are compensated as in training");
  return g;
}

}  // namespace physmas
