// Lists of frames, and files with one frame each, numbered in their names.
#ifndef PHYSMAS_SPLAT_FRAME_FILES_H
#define PHYSMAS_SPLAT_FRAME_FILES_H

#include <string>
#include <vector>

namespace physmas::splat {

// "0,10,20-24": frame numbers in the given order, every one below `count`, ranges upwards. Any other text is an Error
// (exit code 2) about the flag --frames.
std::vector<int> parse_frames(const std::string& list, int count);

// FOLDER/NAME_0000.EXTENSION. folder empty: no files are wanted.
struct FrameFiles {
  std::string folder, name, extension;
  bool wanted() const { return !folder.empty(); }
  std::string path(int frame) const;
};

// Removes the files of that pattern whose frame is not in `frames`: those that a longer run left. Everything else in
// the folder stays. An Error (exit code 3) names the file that cannot be removed.
void remove_other_frames(const FrameFiles& files, const std::vector<int>& frames);

}  // namespace physmas::splat

#endif
