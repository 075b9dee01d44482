#include "masks/coco.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/error.h"
#include "base/file.h"
#include "records/json.h"

namespace physmas::masks {
namespace {

constexpr size_t kMaxAnnotations = 4096;
constexpr size_t kMaxPoints = 1 << 20;  // of one polygon
constexpr double kFarthest = 1e5;       // pixels, of a polygon's point from the image's corner

class Reader {
 public:
  Reader(const std::string& path, const std::vector<SceneView>& views) : path_(path), views_(views) {}

  std::vector<NamedMask> read(const Json& document) {
    if (!document.is_object() || !document.contains("annotations") || !document.at("annotations").is_array())
      throw invalid_field(path_, "/annotations", Json(), "a list of annotations (COCO)");
    read_names(document, "categories", "name", categories_);
    read_names(document, "images", "file_name", images_);
    const Json& annotations = document.at("annotations");
    if (annotations.size() > kMaxAnnotations)
      throw invalid_field(path_, "/annotations", annotations.size(), fmt::format("at most {}", kMaxAnnotations));
    std::vector<NamedMask> masks;
    for (size_t i = 0; i < annotations.size(); ++i) {
      const std::string pointer = fmt::format("/annotations/{}", i);
      const Json& annotation = annotations[i];
      if (!annotation.is_object()) throw invalid_field(path_, pointer, annotation, "an annotation");
      NamedMask named;
      named.view = view_of(annotation, pointer);
      named.name = name_of(annotation, pointer);
      named.mask = mask_of(annotation, views_[named.view], pointer);
      if (named.mask.area() > 0) masks.push_back(std::move(named));
    }
    return masks;
  }

 private:
  using Names = std::map<long, std::string>;

  void read_names(const Json& document, const char* list, const char* field, Names& names) const {
    if (!document.contains(list)) return;
    if (!document.at(list).is_array()) throw invalid_field(path_, std::string("/") + list, document.at(list), "a list");
    for (const Json& entry : document.at(list)) {
      if (!entry.is_object() || !entry.contains("id") || !entry.at("id").is_number_integer() ||
          !entry.contains(field) || !entry.at(field).is_string()) {
        throw invalid_field(path_, std::string("/") + list, entry, std::string("entries with id and ") + field);
      }
      names[entry.at("id").get<long>()] = entry.at(field).get<std::string>();
    }
  }

  // The name that the annotation's `field` refers to.
  const std::string& named(const Json& annotation, const char* field, const Names& names,
                           const std::string& pointer) const {
    if (annotation.contains(field) && annotation.at(field).is_number_integer()) {
      const auto found = names.find(annotation.at(field).get<long>());
      if (found != names.end()) return found->second;
    }
    throw invalid_field(path_, pointer + "/" + field, annotation.value(field, Json()), "an id that the file defines");
  }

  size_t view_of(const Json& annotation, const std::string& pointer) const {
    const std::string file = images_.empty() ? path_ : named(annotation, "image_id", images_, pointer);
    const std::string stem = std::filesystem::path(file).stem().string();
    for (size_t v = 0; v < views_.size(); ++v) {
      if (views_[v].name == stem) return v;
    }
    std::string names;
    for (const SceneView& view : views_) names += (names.empty() ? "" : ", ") + view.name;
    throw invalid_field(path_, pointer, stem, "a picture named after one of the views " + names);
  }

  std::string name_of(const Json& annotation, const std::string& pointer) const {
    if (annotation.contains("class_name") && annotation.at("class_name").is_string())
      return annotation.at("class_name").get<std::string>();
    return named(annotation, "category_id", categories_, pointer);
  }

  double score_of(const Json& annotation, const std::string& pointer) const {
    if (!annotation.contains("score")) return 1;
    const Json& json = annotation.at("score");
    const Json& score = json.is_array() && json.size() == 1 ? json[0] : json;
    if (!score.is_number() || !(score.get<double>() >= 0 && score.get<double>() <= 1))
      throw invalid_field(path_, pointer + "/score", json, "a number in 0..1");
    return score.get<double>();
  }

  Mask mask_of(const Json& annotation, const SceneView& view, const std::string& pointer) const {
    const std::string at = pointer + "/segmentation";
    if (!annotation.contains("segmentation")) throw invalid_field(path_, at, Json(), "RLE or polygons");
    const Json& segmentation = annotation.at("segmentation");
    Mask mask;
    mask.width = view.camera.width;
    mask.height = view.camera.height;
    mask.confidence = score_of(annotation, pointer);
    mask.source = "file";
    mask.pixels.assign(static_cast<size_t>(mask.width) * mask.height, 0);
    if (segmentation.is_object()) {
      fill_runs(segmentation, mask, at);
    } else if (segmentation.is_array()) {
      fill_polygons(segmentation, mask, at);
    } else {
      throw invalid_field(path_, at, segmentation, "RLE or polygons");
    }
    return mask;
  }

  void fill_runs(const Json& rle, Mask& mask, const std::string& at) const {
    const Json size = rle.value("size", Json());
    if (size != Json::array({mask.height, mask.width}))
      throw invalid_field(path_, at + "/size", size,
                          fmt::format("[{}, {}], the view's height and width", mask.height, mask.width));
    const Json counts = rle.value("counts", Json());
    std::vector<uint32_t> runs;
    if (counts.is_string()) {
      runs = runs_from_text(counts.get<std::string>());
    } else if (counts.is_array() && counts.size() <= mask.pixels.size() + 1) {
      for (const Json& run : counts) {
        if (!run.is_number_unsigned() || run.get<uint64_t>() > mask.pixels.size())
          throw invalid_field(path_, at + "/counts", run, "lengths of runs");
        runs.push_back(run.get<uint32_t>());
      }
    }
    size_t position = 0;
    bool inside = false;
    for (const uint32_t run : runs) {
      if (run > mask.pixels.size() - position) {
        position = mask.pixels.size() + 1;
        break;
      }
      for (size_t end = position + run; position < end; ++position) {
        // Columns first.
        if (inside) mask.pixels[position % mask.height * mask.width + position / mask.height] = 255;
      }
      inside = !inside;
    }
    if (position != mask.pixels.size())
      throw invalid_field(path_, at + "/counts", fmt::format("{} runs", runs.size()),
                          fmt::format("runs that fill {} pixels", mask.pixels.size()));
  }

  void fill_polygons(const Json& polygons, Mask& mask, const std::string& at) const {
    // Sixteenths of a pixel; the centre of pixel i is i + 0.5 here and i as OpenCV draws it.
    constexpr int kShift = 4;
    cv::Mat pixels(mask.height, mask.width, CV_8U, mask.pixels.data());
    for (const Json& polygon : polygons) {
      if (!polygon.is_array() || polygon.size() < 6 || polygon.size() % 2 != 0 || polygon.size() > 2 * kMaxPoints)
        throw invalid_field(path_, at, polygon, "polygons [x0, y0, x1, y1, ...] of at least three points");
      std::vector<cv::Point> points;
      for (size_t k = 0; k < polygon.size(); k += 2) {
        int xy[2];
        for (int c = 0; c < 2; ++c) {
          const Json& value = polygon[k + c];
          if (!value.is_number() || !(std::abs(value.get<double>()) <= kFarthest))
            throw invalid_field(path_, at, value, "pixel coordinates");
          xy[c] = static_cast<int>(std::lround((value.get<double>() - 0.5) * (1 << kShift)));
        }
        points.emplace_back(xy[0], xy[1]);
      }
      cv::fillPoly(pixels, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255), cv::LINE_8, kShift);
    }
  }

  const std::string& path_;
  const std::vector<SceneView>& views_;
  Names categories_, images_;
};

}  // namespace

std::vector<uint32_t> runs_from_text(const std::string& text) {
  std::vector<uint32_t> runs;
  for (size_t at = 0; at < text.size();) {
    int64_t value = 0;
    int shift = 0;
    bool more = true;
    while (more) {
      if (at == text.size() || shift > 30) return {};
      const int c = static_cast<unsigned char>(text[at++]) - 48;
      if (c < 0 || c > 63) return {};
      value |= static_cast<int64_t>(c & 0x1f) << shift;
      shift += 5;
      more = (c & 0x20) != 0;
      if (!more && (c & 0x10) != 0) value |= -(int64_t{1} << shift);
    }
    if (runs.size() > 2) value += runs[runs.size() - 2];
    if (value < 0 || value > UINT32_MAX) return {};
    runs.push_back(static_cast<uint32_t>(value));
  }
  return runs;
}

std::vector<NamedMask> load_coco(const std::string& path, const std::vector<SceneView>& views) {
  return coco_from(parse_json(read_file(path), path), path, views);
}

std::vector<NamedMask> coco_from(const Json& document, const std::string& file, const std::vector<SceneView>& views) {
  return Reader(file, views).read(document);
}

}  // namespace physmas::masks
