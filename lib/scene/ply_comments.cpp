#include <fmt/format.h>


#include "base/error.h"
#include "base/words.h"
#include "scene/gaussian_readers.h"

namespace physmas {
namespace {

std::string lower(const std::string& comment) {
  std::string text = lower_case(comment);
  const size_t last = text.find_last_not_of(" \t\r");
  text.resize(last == std::string::npos ? 0 : last + 1);
  const size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first);
}

// What follows `key` at the start of the comment; empty when it starts otherwise.
std::string after(const std::string& comment, const std::string& key) {
  return comment.compare(0, key.size(), key) == 0 ? lower(comment.substr(key.size())) : "";
}

bool is_axis(const std::string& name) {
  const size_t letter = name.find_first_not_of("-+");
  return letter <= 1 && letter + 1 == name.size() && name.find_first_of("xyz") == letter;
}

}  // namespace

void follow_comments(const PlyFile& file, Gaussians& gaussians, GaussianNotes& notes) {
  bool brush = false;
  std::string axis, words;
  for (const std::string& original : file.comments()) {
    const std::string comment = lower(original);
    brush |= comment.find("exported from brush") == 0;
    for (const char* key : {"vertical axis:", "up axis:"}) {
      const std::string name = after(comment, key);
      if (is_axis(name)) axis = name[0] == '+' ? name.substr(1) : name, words = one_line(original, 80);
    }
    // Brush and SplatTransform, Postshot, others.
    const std::string mode = after(comment, "splatrendermode:"), flag = after(comment, "antialiased ");
    const std::string model = after(comment, "splat model:");
    if (mode == "mip" || flag == "1" || model == "antialiased") {
      if (!gaussians.antialiased)
        notes.notes.push_back(fmt::format("\"{}\": opacities are compensated as in training", one_line(original, 80)));
      gaussians.antialiased = true;
    }
  }
  if (axis.empty()) return;
  // Brush has long written y into every file, wherever up was.
  if (brush && axis == "y") {
    notes.notes.push_back(
        fmt::format("\"{}\" is not followed, as Brush writes it into every file; --up y where -y is wrong", words));
    return;
  }
  notes.up = axis;
  notes.notes.push_back(fmt::format("\"{}\": {} is taken as up; --up says otherwise", words, axis));
}

}  // namespace physmas
