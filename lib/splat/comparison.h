// Several videos side by side in one.
#ifndef PHYSMAS_SPLAT_COMPARISON_H
#define PHYSMAS_SPLAT_COMPARISON_H

#include <string>
#include <vector>

namespace physmas::splat {

struct ComparisonOptions {
  std::vector<std::string> videos;  // .mp4, two to 64, all of one frame rate
  std::vector<std::string> titles;  // one per video, or none: the shortest ends of the paths that tell them apart
  std::string out;                  // .mp4
  int columns = 0;                  // 0: as many as make the picture about square
  int cell_width = 480;             // pixels, the most that one video gets
};

// Writes a video with all of them in a grid, row by row, each with its title below. Cells have the first video's shape;
// videos of another shape are fitted in on white. It is as long as the longest; the others stand still at their last
// frame. Returns its number of frames. Errors (exit code 3): no video, another frame rate than the first; exit code 2:
// another number of titles than of videos, or of videos than allowed.
long write_comparison(const ComparisonOptions& options);

}  // namespace physmas::splat

#endif
