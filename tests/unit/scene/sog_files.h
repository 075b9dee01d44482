// Makes a small SOG scene, for tests and seeds.
#ifndef PHYSMAS_TESTS_SOG_FILES_H
#define PHYSMAS_TESTS_SOG_FILES_H

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "records/json.h"
#include "scene/image_file.h"
#include "unit/metrics/npz_bytes.h"

namespace physmas::testing {

// The files of a SOG scene of two Gaussians with harmonics of degree 1.
struct Sog {
  Json meta;
  std::vector<std::pair<std::string, std::string>> images;

  static std::string image(const std::vector<std::array<uint8_t, 4>>& pixels, int width, bool webp) {
    Image picture(width, static_cast<int>(pixels.size()) / width, 4);
    for (size_t i = 0; i < pixels.size(); ++i) std::copy(pixels[i].begin(), pixels[i].end(), &picture.pixels[4 * i]);
    if (!webp) return encode_png(picture);
    cv::Mat bgra(picture.height, picture.width, CV_8UC4);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const auto& p = pixels[i];
      bgra.at<cv::Vec4b>(static_cast<int>(i) / width, static_cast<int>(i) % width) = cv::Vec4b(p[2], p[1], p[0], p[3]);
    }
    std::vector<uint8_t> bytes;
    cv::imencode(".webp", bgra, bytes, {cv::IMWRITE_WEBP_QUALITY, 101});
    return std::string(bytes.begin(), bytes.end());
  }

  explicit Sog(bool webp) {
    std::vector<double> scales(256), colors(256), harmonics(256);
    for (int k = 0; k < 256; ++k) scales[k] = -k / 32.0, colors[k] = k / 64.0 - 2, harmonics[k] = k / 128.0 - 1;
    meta = {
        {"version", 2},
        {"count", 2},
        {"means", {{"mins", {-1, -2, 0}}, {"maxs", {1, 2, 1.5}}, {"files", {"means_l.webp", "means_u.webp"}}}},
        {"scales", {{"codebook", scales}, {"files", {"scales.webp"}}}},
        {"quats", {{"files", {"quats.webp"}}}},
        {"sh0", {{"codebook", colors}, {"files", {"sh0.webp"}}}},
        {"shN",
         {{"count", 3}, {"bands", 1}, {"codebook", harmonics}, {"files", {"shN_centroids.webp", "shN_labels.webp"}}}}};
    // 0x8000, 0xffff, 0 and 0, 0x4000, 0xffff.
    images.emplace_back("means_l.webp", image({{0x00, 0xff, 0x00, 255}, {0x00, 0x00, 0xff, 255}}, 2, webp));
    images.emplace_back("means_u.webp", image({{0x80, 0xff, 0x00, 255}, {0x00, 0x40, 0xff, 255}}, 2, webp));
    images.emplace_back("scales.webp", image({{32, 64, 96, 255}, {0, 128, 255, 255}}, 2, webp));
    // x = 1/sqrt(2) with w left out; y is left out: w, x, z = 0.
    images.emplace_back("quats.webp", image({{255, 128, 128, 252}, {128, 128, 128, 254}}, 2, webp));
    images.emplace_back("sh0.webp", image({{0, 64, 255, 51}, {128, 1, 2, 204}}, 2, webp));
    std::vector<std::array<uint8_t, 4>> palette(64 * 3, {0, 0, 0, 255});
    for (int k = 0; k < 9; ++k) palette[k] = {static_cast<uint8_t>(10 * k), static_cast<uint8_t>(10 * k + 1), 200, 255};
    images.emplace_back("shN_centroids.webp", image(palette, 64 * 3, webp));
    images.emplace_back("shN_labels.webp", image({{2, 0, 0, 255}, {9, 0, 0, 255}}, 2, webp));
  }

  std::string archive() const {
    std::vector<std::pair<std::string, std::string>> entries = {{"meta.json", meta.dump()}};
    entries.insert(entries.end(), images.begin(), images.end());
    return zip(entries, false);
  }
};

}  // namespace physmas::testing

#endif
