#include <doctest/doctest.h>
#include <omp.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "base/error.h"
#include "base/file.h"
#include "scene/image_file.h"
#include "splat/quantize.h"
#include "splat/video.h"
#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::splat;

namespace {

Image noise(int width, int height, int channels, unsigned seed) {
  std::mt19937 random(seed);
  Image image(width, height, channels);
  for (auto& p : image.pixels) p = static_cast<uint8_t>(random());
  return image;
}

// A coloured square that moves over a ramp.
Image moving_square(int width, int height, int t) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      uint8_t* p = image.at(x, y);
      const bool inside = x >= 2 * t && x < 2 * t + 16 && y >= 10 && y < 26;
      p[0] = inside ? 220 : static_cast<uint8_t>(60 + x), p[1] = inside ? 40 : 90,
      p[2] = inside ? 30 : static_cast<uint8_t>(60 + y);
    }
  }
  return image;
}

bool write_video(const std::string& path, int width, int height, int frames) {
  VideoWriter writer(path, width, height, 25);
  for (int t = 0; t < frames; ++t) writer.write(moving_square(width, height, t));
  return writer.finish();
}

template <typename Work>
std::string error_of(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::invalid_input);
    return error.what();
  }
  return "";
}

size_t entries(const std::string& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

}  // namespace

TEST_CASE("splat: PNG files keep every pixel and have one encoding") {
  const TemporaryFolder folder;
  for (int channels : {1, 3, 4}) {
    const Image image = noise(37, 23, channels, channels);
    const std::string path = folder / "a.png";
    CHECK(save_png(path, image));
    const std::string bytes = read_file(path);
    CHECK_FALSE(save_png(path, image));
    cv::setNumThreads(1);
    CHECK(save_png(folder / "b.png", image));
    CHECK(read_file(folder / "b.png") == bytes);
    std::filesystem::remove(folder / "b.png");
    const Image back = load_image(path);
    CHECK(back.channels == channels);
    CHECK(back.pixels == image.pixels);
    for (size_t n : {size_t{8}, size_t{20}, size_t{60}, bytes.size() - 1}) {
      CHECK(error_of([&] { write_file(path, bytes.substr(0, n)), load_image(path); }).find("cut off") !=
            std::string::npos);
    }
    std::string vast = bytes;
    vast[16] = vast[20] = 0x70;
    CHECK(error_of([&] { write_file(path, vast), load_image(path); }).find("IHDR") != std::string::npos);
  }
  CHECK(error_of([&] { load_image(folder / "none.png"); }).find("none.png") != std::string::npos);
  write_file(folder / "text.png", "hello");
  CHECK(error_of([&] { load_image(folder / "text.png"); }).find("PNG") != std::string::npos);
}

TEST_CASE("splat: damaged and cut pictures, and sizes that the bytes cannot hold, are refused") {
  const auto refused = [](const std::string& bytes) { return error_of([&] { decode_image(bytes, "a.png"); }); };
  Image image(40, 30, 3);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<uint8_t>(i * i);
  const std::string png = encode_png(image);
  CHECK(decode_image(png, "a.png").pixels == image.pixels);
  for (size_t i = 8; i < png.size(); ++i) {
    std::string damaged = png;
    damaged[i] = static_cast<char>(damaged[i] ^ 4);
    CHECK_FALSE(refused(damaged).empty());
  }
  std::string large = png;
  large.replace(16, 8, std::string("\0\0\x3f\xff\0\0\x3f\xff", 8));
  CHECK(refused(large).find("which the data can hold") != std::string::npos);

  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", cv::Mat(300, 400, CV_8UC3, cv::Scalar(20, 80, 160)), bytes);
  const std::string jpeg(bytes.begin(), bytes.end());
  CHECK(decode_image(jpeg, "a.jpg").width == 400);
  for (const size_t size : {size_t{3}, size_t{20}, jpeg.size() / 2, jpeg.size() - 2}) {
    INFO(size);
    CHECK(refused(jpeg.substr(0, size)).find("whole JPEG") != std::string::npos);
  }
  std::string huge = jpeg;
  const size_t frame = huge.find("\xff\xc0");
  REQUIRE(frame != std::string::npos);
  huge.replace(frame + 5, 4, "\xff\xff\xff\xff");
  CHECK(refused(huge).find("2^28 pixels") != std::string::npos);
}

TEST_CASE("splat: rendered images are cut above 1 only when they are quantised") {
  RenderedImage image;
  image.width = 2, image.height = 1;
  image.rgb = {1.7f, 0.5f, -0.2f, 0.25f, 0, 0};
  image.alpha = {1, 0.5f};
  CHECK(quantize(image).pixels == std::vector<uint8_t>{255, 128, 0, 64, 0, 0});
  CHECK(quantize_with_alpha(image).pixels == std::vector<uint8_t>{255, 128, 0, 255, 128, 0, 0, 128});
}

TEST_CASE("splat: a contact sheet holds every picture") {
  std::vector<Image> pictures;
  std::vector<std::string> captions;
  for (int t = 0; t < 5; ++t) pictures.push_back(moving_square(64, 48, t)), captions.push_back(std::to_string(t));
  const Image sheet = contact_sheet(pictures, captions, 3, 32);
  CHECK(sheet.width == 3 * (32 + 4) + 4);
  CHECK(sheet.height == 2 * (24 + 18 + 4) + 4);
  CHECK(std::abs(sheet.at(4, 4)[1] - 90) < 3);
  CHECK(contact_sheet(pictures, captions, 3, 32).pixels == sheet.pixels);
}

TEST_CASE("video: exact frame count, right colours, even and odd sizes") {
  const TemporaryFolder folder;
  const std::string path = folder / "v.mp4";
  for (int frames : {1, 2, 50}) {
    write_video(path, 64, 48, frames);
    CHECK(count_decodable_frames(path) == frames);
  }
  int t = 0;
  double worst = 0;
  const VideoInfo info = decode_video(path, [&](const Image& frame) {
    const Image expected = moving_square(64, 48, t++);
    double sum = 0;
    for (size_t i = 0; i < frame.pixels.size(); ++i) sum += std::pow(double(frame.pixels[i]) - expected.pixels[i], 2);
    worst = std::max(worst, std::sqrt(sum / frame.pixels.size()));
  });
  CHECK(t == 50);
  CHECK(info.width == 64);
  CHECK(info.fps == doctest::Approx(25));
  CHECK(worst < 8);  // levels, most of it from colour at the square's edge, which is stored at half resolution
  write_video(path, 63, 41, 7);
  CHECK(decode_video(path).width == 64);
  CHECK(decode_video(path).height == 42);
  CHECK(count_decodable_frames(path) == 7);
  write_video(path, 1, 1, 3);
  CHECK(count_decodable_frames(path) == 3);
}

TEST_CASE("video: the same frames give the same bytes, without times or versions") {
  const TemporaryFolder folder;
  const std::string a = folder / "a.mp4", b = folder / "b.mp4";
  CHECK(write_video(a, 160, 120, 30));
  CHECK_FALSE(write_video(a, 160, 120, 30));
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  write_video(b, 160, 120, 30);
  omp_set_num_threads(before);
  const std::string bytes = read_file(a);
  CHECK(bytes == read_file(b));
  CHECK(bytes.find("x264") == std::string::npos);
  CHECK(bytes.find("Lavf") == std::string::npos);
  CHECK(bytes.find("moov") < bytes.find("mdat"));
}

TEST_CASE("video: damaged and foreign files are refused") {
  const TemporaryFolder folder;
  const std::string path = folder / "v.mp4";
  write_video(path, 96, 96, 40);
  const std::string bytes = read_file(path);
  for (double part : {0.0, 0.05, 0.3, 0.6, 0.95}) {
    write_file(path, bytes.substr(0, static_cast<size_t>(part * bytes.size())));
    CHECK(error_of([&] { count_decodable_frames(path); }).find("v.mp4") != std::string::npos);
  }
  write_file(path, "no video");
  // libav would wait for somebody who writes.
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  CHECK(error_of([&] { count_decodable_frames(folder / "pipe"); }).find("found a pipe") != std::string::npos);
  CHECK(error_of([&] { count_decodable_frames(path); }) != "");
  CHECK(error_of([&] { count_decodable_frames(folder / "none.mp4"); }).find("No such file") != std::string::npos);
}

TEST_CASE("video: an unfinished or failed video leaves nothing behind") {
  const TemporaryFolder folder;
  {
    VideoWriter writer(folder / "v.mp4", 64, 48, 25);
    writer.write(moving_square(64, 48, 0));
  }
  CHECK(entries(folder.path()) == 0);
  CHECK(error_of([&] { VideoWriter("/proc/v.mp4", 64, 48, 25); }) != "");
  // A file-size limit stands for a full disk.
  rlimit old_limit;
  getrlimit(RLIMIT_FSIZE, &old_limit);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = old_limit;
  limit.rlim_cur = 20000;
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string text = error_of([&] {
    VideoWriter writer(folder / "v.mp4", 128, 128, 25);
    for (int t = 0; t < 20; ++t) writer.write(noise(128, 128, 3, t));
    writer.finish();
  });
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  CHECK(text.find("v.mp4: cannot be written") != std::string::npos);
  CHECK(entries(folder.path()) == 0);
}
