#include "metrics/query_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "scene/image_file.h"

namespace fs = std::filesystem;

namespace physmas::metrics {
namespace {

constexpr size_t kMaxMasks = 10000;

bool inside_eroded(const Image& mask, int x, int y) {
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (u < 0 || v < 0 || u >= mask.width || v >= mask.height || *mask.at(u, v) == 0) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<QueryPixel> query_pixels(const Image& mask) {
  std::vector<QueryPixel> queries;
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const QueryPixel q = {static_cast<int>((i + 0.5) * mask.width / kGrid),
                            static_cast<int>((j + 0.5) * mask.height / kGrid)};
      if (inside_eroded(mask, q.x, q.y)) queries.push_back(q);
    }
  }
  return queries;
}

std::vector<Image> load_masks(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path().string());
  }
  if (failure) throw system_error(folder, "cannot be read", failure.value());
  if (files.empty() || files.size() > kMaxMasks)
    throw invalid_input({folder, "", fmt::format("{} PNG files", files.size()), "one mask per frame"});
  std::sort(files.begin(), files.end());
  std::vector<Image> masks;
  for (const std::string& file : files) {
    Image image = load_image(file);
    if (image.channels != 1)
      throw invalid_input({file, "", fmt::format("{} channels", image.channels), "a grey picture"});
    if (!masks.empty() && (image.width != masks[0].width || image.height != masks[0].height))
      throw invalid_input({file, "", fmt::format("{} x {} pixels", image.width, image.height),
                           fmt::format("{} x {} as in {}", masks[0].width, masks[0].height, files[0])});
    for (uint8_t& p : image.pixels) p = p > 127 ? 255 : 0;
    masks.push_back(std::move(image));
  }
  return masks;
}

void restrict_to_masks(Tracks& tracks, const std::vector<Image>& masks, const std::string& source) {
  if (masks.size() != tracks.frames())
    throw invalid_input(
        {source, "", fmt::format("{} masks", masks.size()), fmt::format("{}, one per frame", tracks.frames())});
  for (size_t t = 0; t < masks.size(); ++t) {
    const Image& mask = masks[t];
    if (mask.width != tracks.width || mask.height != tracks.height)
      throw invalid_input({source, "", fmt::format("masks of {} x {} pixels", mask.width, mask.height),
                           fmt::format("{} x {} as the tracks", tracks.width, tracks.height)});
    for (size_t i = 0; i < tracks.points(); ++i) {
      const Eigen::Vector2d& u = tracks.position[t][i];
      const bool inside = u.allFinite() && u.x() >= 0 && u.y() >= 0 && u.x() < mask.width && u.y() < mask.height;
      if (!inside || *mask.at(static_cast<int>(u.x()), static_cast<int>(u.y())) == 0) tracks.visible[t][i] = 0;
    }
  }
}

std::vector<long> mask_areas(const std::vector<Image>& masks) {
  std::vector<long> areas;
  for (const Image& mask : masks)
    areas.push_back(static_cast<long>(mask.pixels.size()) -
                    static_cast<long>(std::count(mask.pixels.begin(), mask.pixels.end(), uint8_t{0})));
  return areas;
}

}  // namespace physmas::metrics
