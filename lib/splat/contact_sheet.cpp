#include "splat/contact_sheet.h"

#include <algorithm>

#include "scene/image_file.h"

namespace physmas::splat {

ContactSheet::ContactSheet(size_t frames) : count_(std::min<size_t>(frames, 8)), frames_(frames) {}

void ContactSheet::add(size_t i, int frame, const Image& image) {
  const size_t k = pictures_.size();
  if (k == count_ || i != (count_ == 1 ? 0 : k * (frames_ - 1) / (count_ - 1))) return;
  pictures_.push_back(image);
  captions_.push_back("frame " + std::to_string(frame));
}

void ContactSheet::save(const std::string& path) const {
  save_png(path, contact_sheet(pictures_, captions_, 4, 360));
}

}  // namespace physmas::splat
