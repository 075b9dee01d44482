// What a file of Gaussians or a scene holds, for people.
#ifndef PHYSMAS_BUNDLE_REPORT_H
#define PHYSMAS_BUNDLE_REPORT_H

#include <string>

namespace physmas::bundle {

// Prints counts, bounds, degree, and histograms of opacities and scales to stdout; for scene.json its parts first.
// Warns of floaters on stderr (selection.h). Throws what the readers throw.
void print_report(const std::string& path);

}  // namespace physmas::bundle

#endif
