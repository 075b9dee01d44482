#include "records/rollout.h"

#include <fmt/format.h>

#include "base/error.h"

namespace physmas {

RolloutWriter::RolloutWriter(const std::string& path, uint64_t gaussian_count, const std::string& deformation,
                             const Provenance& provenance)
    : file_(path, "rollout", provenance) {
  file_.create_series("/frames/position", {gaussian_count, 3});
  file_.create_series("/frames/F", {gaussian_count, 9});
  file_.write_text_attribute("/frames/F", "deformation", deformation);
  file_.create_series("/frames/velocity", {gaussian_count, 3});
}

void RolloutWriter::append(double time, const float* position, const float* F, const float* velocity) {
  file_.append_slab("/frames/position", position);
  file_.append_slab("/frames/F", F);
  file_.append_slab("/frames/velocity", velocity);
  times_.push_back(static_cast<float>(time));
}

void RolloutWriter::commit() {
  file_.write_float("/frames/time", {times_.size()}, times_.data());
  file_.commit();
}

RolloutReader::RolloutReader(const std::string& path, uint64_t gaussian_count) : file_(path, "rollout") {
  file_.allow_only({"/frames/time", "/frames/position", "/frames/F", "/frames/velocity"});
  times_ = file_.read_float("/frames/time", {UINT64_MAX}, 100000);
  const uint64_t frames = times_.size();
  const auto check = [&](const char* dataset, uint64_t width) {
    const std::vector<uint64_t> shape = file_.shape(dataset);
    if (shape != std::vector<uint64_t>{frames, gaussian_count, width}) {
      throw file_.invalid(dataset, fmt::format("{} values", shape.size()),
                          fmt::format("shape [{}, {}, {}]", frames, gaussian_count, width));
    }
  };
  check("/frames/position", 3);
  check("/frames/F", 9);
  check("/frames/velocity", 3);
}

RolloutFrame RolloutReader::frame(int t) const {
  const uint64_t index = static_cast<uint64_t>(t);
  return {file_.read_float_slab("/frames/position", index, 1), file_.read_float_slab("/frames/F", index, 1),
          file_.read_float_slab("/frames/velocity", index, 1)};
}

}  // namespace physmas
