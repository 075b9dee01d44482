#include "scene/image_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/foreign_lines.h"
#include "base/log.h"
#include "base/machine_limits.h"

namespace physmas {
namespace {

constexpr size_t kMaxImageBytes = size_t{1} << 30;
constexpr uint64_t kMaxPixels = 1 << 28;
constexpr int kCaptionFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCaptionScale = 0.42;

// A header over the image's own pixels; OpenCV does not write through it here.
cv::Mat view(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels), const_cast<uint8_t*>(image.pixels.data()));
}

// Our channel order from OpenCV's, or back: the exchange is its own inverse.
cv::Mat swap_red_and_blue(const cv::Mat& m) {
  cv::Mat out;
  switch (m.channels()) {
    case 3:
      cv::cvtColor(m, out, cv::COLOR_BGR2RGB);
      return out;
    case 4:
      cv::cvtColor(m, out, cv::COLOR_BGRA2RGBA);
      return out;
    default:
      return m;
  }
}

Image image_of(const cv::Mat& m) {
  Image image(m.cols, m.rows, m.channels());
  m.copyTo(view(image));
  return image;
}

// type: ".png" or ".jpg".
std::string encode(const cv::Mat& pixels, const char* type, const std::vector<int>& parameters) {
  std::vector<uint8_t> bytes;
  // A picture of ours can be encoded, unless there is no memory; OpenCV's libraries would print a line of their own
  // then.
  const ForeignLines kept;
  bool encoded = false;
  try {
    encoded = cv::imencode(type, pixels, bytes, parameters);
  } catch (const cv::Exception&) {
  }
  if (!encoded) throw out_of_memory();
  return std::string(bytes.begin(), bytes.end());
}

// Stated, so that a change of OpenCV's defaults does not change our bytes.
std::string encode(const cv::Mat& pixels) {
  return encode(pixels, ".png",
                {cv::IMWRITE_PNG_COMPRESSION, 4, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT});
}

// The caption, or as much of it as fits into `width` pixels, ending in dots.
std::string fitting(const std::string& caption, int width) {
  std::string text = caption;
  for (size_t kept = caption.size(); kept > 0; text = caption.substr(0, --kept) + "...") {
    if (cv::getTextSize(text, kCaptionFont, kCaptionScale, 1, nullptr).width <= width) break;
  }
  return text;
}

// Big-endian.
uint32_t number(const std::string& bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// OpenCV would allocate whatever size the header claims. most: what `bytes` bytes of data can hold.
void check_size(const std::string& path, const char* field, uint64_t width, uint64_t height, uint64_t most) {
  if (width == 0 || height == 0 || width > kMaxPixels || height > kMaxPixels / width)
    throw invalid_input({path, field, fmt::format("{} x {} pixels", width, height), "1 to 2^28 pixels"});
  if (width * height > most)
    throw invalid_input({path, field, fmt::format("{} x {} pixels", width, height),
                         fmt::format("at most {}, which the data can hold", most), "the file is cut off"});
}

// Walks the chunks of a PNG: libpng would print its own line about a file that is cut off or damaged.
void check_png(const std::string& path, const std::string& bytes) {
  constexpr uint64_t kPixelsPerByte = 1032 * 8;  // the ratio of deflate, one bit per pixel
  size_t at = 8;                                 // after the signature
  for (std::string type; type != "IEND";) {
    const size_t length = at + 12 <= bytes.size() ? number(bytes, at, 4) : bytes.size();
    if (length > bytes.size() - at || bytes.size() - at - length < 12) {
      throw invalid_input(
          {path, fmt::format("byte {}", at), "the end of the file", "a whole PNG chunk", "the file is cut off"});
    }
    type = bytes.substr(at + 4, 4);
    if (at == 8) {
      if (type != "IHDR" || length != 13) throw invalid_input({path, "byte 8", "another chunk", "IHDR of 13 bytes"});
      check_size(path, "IHDR", number(bytes, at + 8, 4), number(bytes, at + 12, 4), kPixelsPerByte * bytes.size());
    }
    const uLong sum = crc32(0, reinterpret_cast<const Bytef*>(&bytes[at + 4]), static_cast<uInt>(length + 4));
    if (sum != number(bytes, at + 8 + length, 4))
      throw invalid_input(
          {path, fmt::format("byte {}", at), "damaged data", "a PNG chunk with the sum that it states"});
    at += 12 + length;
  }
}

// Walks the segments of a JPEG up to the frame header, which holds the size.
void check_jpeg(const std::string& path, const std::string& bytes) {
  constexpr uint64_t kPixelsPerByte = 8 * 16 * 64;  // a bit per block of 8 x 8, of a component at a quarter of the size
  for (size_t at = 2; at + 9 <= bytes.size();) {
    if (number(bytes, at, 1) != 0xff) break;
    const uint32_t marker = number(bytes, at + 1, 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) {
      check_size(path, "frame header", number(bytes, at + 7, 2), number(bytes, at + 5, 2),
                 kPixelsPerByte * bytes.size());
      // OpenCV would take what is there and leave the rest grey.
      if (bytes.find("\xff\xd9", at) == std::string::npos)
        throw invalid_input({path, "", "no end of image", "a whole JPEG image", "the file is cut off"});
      return;
    }
    const bool alone = marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    at += 2 + (alone ? 0 : number(bytes, at + 2, 2));
  }
  throw invalid_input({path, "", "no frame header", "a whole JPEG image"});
}

// Little-endian.
uint32_t little(const std::string& bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = count - 1; i >= 0; --i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// The size in the first chunk of a WebP.
void check_webp(const std::string& path, const std::string& bytes, uint64_t most) {
  if (bytes.size() < 30 || little(bytes, 4, 4) > bytes.size() - 8)
    throw invalid_input({path, "", fmt::format("{} bytes", bytes.size()), "a whole WebP image", "the file is cut off"});
  const std::string chunk = bytes.substr(12, 4);
  if (chunk == "VP8L") {
    const uint32_t bits = little(bytes, 21, 4);
    check_size(path, "VP8L", (bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1, most);
  } else if (chunk == "VP8X") {
    check_size(path, "VP8X", little(bytes, 24, 3) + 1, little(bytes, 27, 3) + 1, most);
    if (bytes.find("VP8L", 30) == std::string::npos)
      throw invalid_input({path, "", "no lossless picture", "a WebP image without loss"});
  } else {
    throw invalid_input({path, "byte 12", "a WebP image with loss", "one without, as its values are no colours"});
  }
}

}  // namespace

std::string encode_png(const Image& image) {
  return encode(swap_red_and_blue(view(image)));
}

std::string encode_png(int width, int height, const std::vector<uint16_t>& levels) {
  return encode(cv::Mat(height, width, CV_16UC1, const_cast<uint16_t*>(levels.data())));
}

std::string encode_jpeg(const Image& image, int quality) {
  return encode(swap_red_and_blue(view(image)), ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

bool save_png(const std::string& path, const Image& image) {
  return write_file(path, encode_png(image));
}

Image load_image(const std::string& path) {
  return decode_image(read_file(path, kMaxImageBytes), path);
}

namespace {

// kind: for messages.
cv::Mat decoded(const std::string& bytes, const std::string& path, const char* kind) {
  cv::Mat pixels;
  ForeignLines foreign;
  try {
    const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    pixels = cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    throw invalid_input({path, "", one_line(error.err), "a decodable image"});
  }
  const std::string lines = one_line(foreign.take(), 200);
  if (pixels.empty()) throw invalid_input({path, "", "data that cannot be decoded", kind, lines});
  if (!lines.empty()) log_info(path + ": read, although " + lines);
  if (pixels.depth() == CV_16U) pixels.convertTo(pixels, CV_8U, 1 / 257.0);
  if (pixels.depth() != CV_8U || pixels.channels() == 2) {
    throw invalid_input({path, "", "an unusual pixel format", "8 or 16 bits; grey, RGB or RGBA"});
  }
  return pixels;
}

bool is_png(const std::string& bytes) {
  return bytes.compare(0, 8, "\x89PNG\r\n\x1a\n") == 0;
}

}  // namespace

Image decode_image(const std::string& bytes, const std::string& path) {
  const bool jpeg = bytes.compare(0, 3, "\xff\xd8\xff") == 0;
  if (!is_png(bytes) && !jpeg)
    throw invalid_input({path, "byte 0", "neither a PNG nor a JPEG signature", "a PNG or JPEG image"});
  is_png(bytes) ? check_png(path, bytes) : check_jpeg(path, bytes);
  return image_of(swap_red_and_blue(decoded(bytes, path, "a whole PNG or JPEG image")));
}

Image decode_rgba(const std::string& bytes, const std::string& path, uint64_t most) {
  const bool webp = bytes.size() >= 12 && bytes.compare(0, 4, "RIFF") == 0 && bytes.compare(8, 4, "WEBP") == 0;
  if (!is_png(bytes) && !webp)
    throw invalid_input({path, "byte 0", "neither a WebP nor a PNG signature", "a lossless WebP or PNG image"});
  if (webp) {
    check_webp(path, bytes, most);
  } else {
    check_png(path, bytes);
    check_size(path, "IHDR", number(bytes, 16, 4), number(bytes, 20, 4), most);
  }
  const cv::Mat pixels = decoded(bytes, path, "a whole WebP or PNG image");
  check_size(path, "", static_cast<uint64_t>(pixels.cols), static_cast<uint64_t>(pixels.rows), most);
  cv::Mat rgba;
  const int channels = pixels.channels();
  cv::cvtColor(pixels, rgba,
               channels == 1   ? cv::COLOR_GRAY2RGBA
               : channels == 3 ? cv::COLOR_BGR2RGBA
                               : cv::COLOR_BGRA2RGBA);
  return image_of(rgba);
}

Image fit_into(const Image& picture, int width, int height) {
  if (picture.width == width && picture.height == height) return picture;
  const double scale = std::min(double(width) / picture.width, double(height) / picture.height);
  const int w = std::clamp(static_cast<int>(std::lround(scale * picture.width)), 1, width);
  const int h = std::clamp(static_cast<int>(std::lround(scale * picture.height)), 1, height);
  cv::Mat out(height, width, CV_8UC(picture.channels), cv::Scalar::all(255));
  cv::Mat place = out(cv::Rect((width - w) / 2, (height - h) / 2, w, h));
  cv::resize(view(picture), place, place.size(), 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return image_of(out);
}

void write_caption(Image& picture, const std::vector<std::string>& paragraphs) {
  constexpr int kMargin = 6, kLine = 16, kCaptionShare = 3;
  constexpr double kShine = 0.2;
  const auto width_of = [](const std::string& text) {
    int base = 0;
    return cv::getTextSize(text, kCaptionFont, kCaptionScale, 1, &base).width;
  };
  std::vector<std::string> lines;
  for (const std::string& paragraph : paragraphs) {
    std::istringstream words(paragraph);
    std::string line, word;
    while (words >> word) {
      const std::string longer = line.empty() ? word : line + " " + word;
      if (line.empty() || width_of(longer) <= picture.width - 2 * kMargin) {
        line = longer;
      } else {
        lines.push_back(line);
        line = "  " + word;
      }
    }
    if (!line.empty()) lines.push_back(line);
  }
  // The picture below stays what one looks at; where it is as good as nothing, a line fits.
  const int most = picture.height / kCaptionShare - 2 * kMargin, least = picture.height - 2 * kMargin >= kLine ? 1 : 0;
  const size_t room = static_cast<size_t>(std::max(least, most / kLine));
  if (lines.size() > room) {
    lines.resize(room);
    if (room > 0) lines.back() += " ...";
  }
  if (lines.empty()) return;
  int width = 0;
  for (const std::string& line : lines) width = std::max(width, width_of(line));
  cv::Mat pixels(picture.height, picture.width, CV_8UC(picture.channels), picture.pixels.data());
  cv::Mat box = pixels(cv::Rect(0, 0, std::min(picture.width, width + 2 * kMargin),
                                static_cast<int>(lines.size()) * kLine + 2 * kMargin));
  box.convertTo(box, -1, kShine, 255 * (1 - kShine));
  for (size_t i = 0; i < lines.size(); ++i) {
    cv::putText(pixels, lines[i], {kMargin, kMargin + static_cast<int>(i + 1) * kLine - 4}, kCaptionFont, kCaptionScale,
                picture.channels == 4 ? cv::Scalar(0, 0, 0, 255) : cv::Scalar::all(0), 1, cv::LINE_AA);
  }
}

Image contact_sheet(const std::vector<Image>& pictures, const std::vector<std::string>& captions, int columns,
                    int cell_width) {
  if (pictures.empty() || pictures.size() != captions.size() || columns < 1 || cell_width < 1) {
    throw internal_error("a contact sheet needs pictures, a caption each, and room");
  }
  const Image& first = pictures[0];
  const int width = std::min(cell_width, first.width);
  const int height = std::max(1, static_cast<int>(std::lround(double(first.height) * width / first.width)));
  columns = std::min<int>(columns, static_cast<int>(pictures.size()));
  const int rows = static_cast<int>((pictures.size() + columns - 1) / columns);
  constexpr int kGap = 4, kCaption = 18;
  cv::Mat sheet(rows * (height + kCaption + kGap) + kGap, columns * (width + kGap) + kGap, CV_8UC(first.channels),
                cv::Scalar::all(255));
  for (size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].width != first.width || pictures[i].height != first.height ||
        pictures[i].channels != first.channels) {
      throw internal_error("the pictures of a contact sheet differ in size");
    }
    const int x = kGap + static_cast<int>(i % columns) * (width + kGap);
    const int y = kGap + static_cast<int>(i / columns) * (height + kCaption + kGap);
    cv::Mat cell = sheet(cv::Rect(x, y, width, height));
    cv::resize(view(pictures[i]), cell, cell.size(), 0, 0, cv::INTER_AREA);
    cv::putText(sheet, fitting(captions[i], width - 4), {x + 2, y + height + kCaption - 5}, kCaptionFont, kCaptionScale,
                first.channels == 4 ? cv::Scalar(0, 0, 0, 255) : cv::Scalar::all(0), 1, cv::LINE_AA);
  }
  return image_of(sheet);
}

}  // namespace physmas
