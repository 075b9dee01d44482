// The page before the waiting: the four views with what was understood of them, and a way to say it better.
#ifndef PHYSMAS_REPORT_PREVIEW_H
#define PHYSMAS_REPORT_PREVIEW_H

#include <string>

namespace physmas::report {

struct PreviewOptions {
  std::string run;  // the run's folder, grounded; with lifting and materials as far as they are there
  std::string out;  // .html; a picture .png, the record .json and the coarse motion .mp4 go beside it
};

// Writes the page: views with axes, floor, box and arrows for every action, parts in colours, the plan in words, the
// coarse motion of the first candidate and materials as assumed. On it a person marks parts with polygons, states
// materials and changes actions; it saves records for INVENTORY=, AUTHORED= and PLAN=. Errors (exit code 3) as
// load_run, and where nothing was grounded yet.
void write_preview(const PreviewOptions& options);

}  // namespace physmas::report

#endif
