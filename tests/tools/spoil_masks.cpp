// Masks of medium quality, made of good ones: what detectors and segmenters get wrong.
//   spoil_masks IN OUT KIND [AMOUNT]   IN: a folder of VIEW/OBJECT.png and VIEW/OBJECT/PART.png
//     holes F     discs of a tenth of the mask's size are cut out until the fraction F of it is gone
//     bleed R     every mask grows by R pixels for each 100 of the picture's width
//     shrink R    and shrinks by as much
//     missing N   nothing was found in the first N views, in alphabetical order
//     swapped N   in the first N views every part has the mask of the next part; with one part, every object
//     medium R    holes of 0.15, then bleed R
// The same masks give the same spoilt ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "scene/image_file.h"

using namespace physmas;
namespace fs = std::filesystem;

namespace {

cv::Mat as_matrix(Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC1, image.pixels.data());
}

void grow(Image& mask, double percent) {
  const int radius = static_cast<int>(std::lround(std::abs(percent) * mask.width / 100));
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::Mat pixels = as_matrix(mask), changed;
  if (percent > 0) {
    cv::dilate(pixels, changed, disc);
  } else {
    cv::erode(pixels, changed, disc);
  }
  changed.copyTo(pixels);
}

void cut_holes(Image& mask, double fraction, const std::string& name) {
  cv::Mat pixels = as_matrix(mask);
  const cv::Rect box = cv::boundingRect(pixels);
  const int before = cv::countNonZero(pixels), radius = std::max(1, std::max(box.width, box.height) / 20);
  if (before == 0) return;
  std::mt19937 random(static_cast<unsigned>(std::stoul(sha256_text(name).substr(0, 8), nullptr, 16)));
  for (int tries = 0; tries < 10000 && cv::countNonZero(pixels) > (1 - fraction) * before; ++tries) {
    const int x = box.x + static_cast<int>(random() % static_cast<unsigned>(box.width));
    const int y = box.y + static_cast<int>(random() % static_cast<unsigned>(box.height));
    cv::circle(pixels, {x, y}, radius, 0, cv::FILLED);
  }
}

// The masks of one view that can be taken for one another: of the parts, else of the objects.
std::vector<fs::path> alike(const std::vector<fs::path>& files) {
  std::vector<fs::path> parts, objects;
  for (const fs::path& file : files) (std::distance(file.begin(), file.end()) == 3 ? parts : objects).push_back(file);
  return parts.size() > 1 ? parts : objects;
}

void spoil(const fs::path& in, const fs::path& out, const std::string& kind, double amount) {
  std::map<std::string, std::vector<fs::path>> views;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(in)) {
    if (!entry.is_regular_file() || entry.path().extension() != ".png") continue;
    const fs::path file = fs::relative(entry.path(), in);
    views[file.begin()->string()].push_back(file);
  }
  if (views.empty()) throw Error(ExitCode::usage, in.string() + ": found no masks");
  int number = 0;
  for (auto& [view, files] : views) {
    const bool of_first = number++ < amount;
    if (kind == "missing" && of_first) continue;
    std::sort(files.begin(), files.end());
    std::map<fs::path, fs::path> source;
    for (const fs::path& file : files) source[file] = file;
    if (kind == "swapped" && of_first) {
      const std::vector<fs::path> around = alike(files);
      for (size_t i = 0; i < around.size(); ++i) source[around[i]] = around[(i + 1) % around.size()];
    }
    for (const fs::path& file : files) {
      Image mask = load_image((in / source.at(file)).string());
      if (mask.channels != 1) throw Error(ExitCode::usage, file.string() + ": expected grey masks");
      if (kind == "holes") cut_holes(mask, amount, file.string());
      if (kind == "medium") cut_holes(mask, 0.15, file.string());
      if (kind == "bleed" || kind == "medium") grow(mask, amount);
      if (kind == "shrink") grow(mask, -amount);
      fs::create_directories((out / file).parent_path());
      save_png((out / file).string(), mask);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::set<std::string> kinds = {"holes", "bleed", "shrink", "missing", "swapped", "medium"};
  if (argc < 4 || kinds.count(argv[3]) == 0) {
    std::fprintf(stderr, "spoil_masks IN OUT holes|bleed|shrink|missing|swapped|medium [AMOUNT]\n");
    return 2;
  }
  try {
    spoil(argv[1], argv[2], argv[3], argc > 4 ? std::stod(argv[4]) : 1);
  } catch (const Error& e) {
    std::fprintf(stderr, "spoil_masks: %s\n", e.what());
    return static_cast<int>(e.code());
  }
}
