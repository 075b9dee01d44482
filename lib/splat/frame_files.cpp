#include "splat/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/file.h"

namespace fs = std::filesystem;

namespace physmas::splat {
namespace {

// The frame whose file has this name; -1 when it is another file.
int frame_of(const FrameFiles& files, const std::string& name) {
  const size_t first = files.name.size() + 1;
  if (name.size() <= first) return -1;
  const std::string digits = name.substr(first, name.find('.', first) - first);
  if (digits.size() < 4 || digits.size() > 6 || digits.find_first_not_of("0123456789") != std::string::npos) return -1;
  const int frame = std::stoi(digits);
  return fs::path(files.path(frame)).filename() == name ? frame : -1;
}

}  // namespace

std::vector<int> parse_frames(const std::string& list, int count) {
  std::vector<int> frames;
  size_t at = 0;
  const auto bad = [&] {
    return Error(ExitCode::usage,
                 fmt::format("--frames: found \"{}\", expected frame numbers and ranges below {}, such as 0,10,20-24",
                             list, count));
  };
  const auto number = [&]() -> int {
    size_t end = at;
    while (end < list.size() && std::isdigit(static_cast<unsigned char>(list[end])) != 0) ++end;
    if (end == at || end - at > 6) throw bad();
    const int value = std::stoi(list.substr(at, end - at));
    at = end;
    if (value >= count) throw bad();
    return value;
  };
  const auto follows = [&](char c) { return at < list.size() && list[at] == c && ++at > 0; };
  do {
    const int first = number();
    const int last = follows('-') ? number() : first;
    if (last < first) throw bad();
    for (int t = first; t <= last; ++t) frames.push_back(t);
  } while (follows(','));
  if (at != list.size()) throw bad();
  return frames;
}

std::string FrameFiles::path(int frame) const {
  return join_path(folder, fmt::format("{}_{:04d}.{}", name, frame, extension));
}

void remove_other_frames(const FrameFiles& files, const std::vector<int>& frames) {
  std::error_code failure;
  std::set<int> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(files.folder, failure)) {
    const int frame = frame_of(files, entry.path().filename().string());
    if (frame >= 0 && entry.symlink_status().type() == fs::file_type::regular) others.insert(frame);
  }
  for (const int frame : frames) others.erase(frame);
  // From the end, so that what is left is a sequence from its start even when this is cut short.
  std::for_each(others.rbegin(), others.rend(), [&](int frame) {
    const std::string path = files.path(frame);
    if (!fs::remove(path, failure) && failure) throw system_error(path, "cannot be removed", failure.value());
  });
}

}  // namespace physmas::splat
