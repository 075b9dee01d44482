// A few pictures of a video on one page.
#ifndef PHYSMAS_SPLAT_CONTACT_SHEET_H
#define PHYSMAS_SPLAT_CONTACT_SHEET_H

#include <string>
#include <vector>

#include "scene/image.h"

namespace physmas::splat {

// Collects some of a video's frames as they come: at most eight, evenly spaced, the first and the last among them.
class ContactSheet {
 public:
  explicit ContactSheet(size_t frames);
  // The i-th picture, in order from 0; frame: its number, for the caption.
  void add(size_t i, int frame, const Image& image);
  // Writes the pictures that were kept, four in a row, as PNG.
  void save(const std::string& path) const;

 private:
  size_t count_, frames_;  // kept at most, and all
  std::vector<Image> pictures_;
  std::vector<std::string> captions_;
};

}  // namespace physmas::splat

#endif
