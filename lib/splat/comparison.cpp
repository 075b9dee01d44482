#include "splat/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "base/error.h"
#include "scene/image.h"
#include "scene/image_file.h"
#include "splat/video.h"

namespace physmas::splat {
namespace {

constexpr size_t kMaxVideos = 64;

// The last `parts` parts of the path, without the extension.
std::string end_of_path(const std::string& path, int parts) {
  const std::filesystem::path whole(path);
  std::string end = whole.stem().string();
  std::filesystem::path folder = whole.parent_path();
  for (int k = 1; k < parts && folder.has_filename(); ++k, folder = folder.parent_path()) {
    end = folder.filename().string() + "/" + end;
  }
  return end;
}

std::vector<std::string> default_titles(const std::vector<std::string>& videos) {
  constexpr int kParts = 5;
  std::vector<std::string> titles;
  for (int parts = 1; parts <= kParts; ++parts) {
    titles.clear();
    for (const std::string& video : videos) titles.push_back(end_of_path(video, parts));
    if (std::set<std::string>(titles.begin(), titles.end()).size() == titles.size()) break;
  }
  return titles;
}

}  // namespace

long write_comparison(const ComparisonOptions& options) {
  const size_t count = options.videos.size();
  if (count < 2 || count > kMaxVideos) {
    throw Error(ExitCode::usage, fmt::format("VIDEO: found {} videos, expected 2 to {}", count, kMaxVideos));
  }
  const std::vector<std::string> titles = options.titles.empty() ? default_titles(options.videos) : options.titles;
  if (titles.size() != count) {
    throw Error(ExitCode::usage,
                fmt::format("--title: found {}, expected one for each of the {} videos", options.titles.size(), count));
  }
  std::vector<std::unique_ptr<VideoReader>> readers;
  for (const std::string& video : options.videos) {
    readers.push_back(std::make_unique<VideoReader>(video));
    const double fps = readers.back()->info().fps, expected = readers[0]->info().fps;
    if (!(fps > 0) || std::abs(fps - expected) > 1e-3 * expected) {
      throw invalid_input({video, "frame rate", fmt::format("{:g} per second", fps),
                           fps > 0 ? fmt::format("{:g} as in {}", expected, options.videos[0]) : "a constant rate"});
    }
  }
  const VideoInfo& shape = readers[0]->info();
  const int width = std::min(options.cell_width, shape.width);
  const int height = std::max(1, static_cast<int>(std::lround(double(shape.height) * width / shape.width)));
  const int columns =
      options.columns > 0 ? options.columns : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));

  std::unique_ptr<VideoWriter> writer;
  std::vector<Image> cells(count);
  std::vector<bool> running(count, true);
  long frames = 0;
  for (;; ++frames) {
    bool any = false;
    for (size_t k = 0; k < count; ++k) {
      Image frame;
      if (!running[k] || !(running[k] = readers[k]->next(&frame))) continue;
      cells[k] = fit_into(frame, width, height);
      any = true;
    }
    if (!any) break;
    const Image picture = contact_sheet(cells, titles, columns, width);
    if (!writer) writer = std::make_unique<VideoWriter>(options.out, picture.width, picture.height, shape.fps);
    writer->write(picture);
  }
  writer->finish();
  return frames;
}

}  // namespace physmas::splat
