// Plots through gnuplot, where it is installed.
#ifndef PHYSMAS_STUDIES_GNUPLOT_H
#define PHYSMAS_STUDIES_GNUPLOT_H

#include <string>

namespace physmas::studies {

// Writes folder/name and runs gnuplot on it in that folder. False, with a warning that says what to do, when gnuplot is
// missing or fails; the script stays there for later.
bool run_gnuplot(const std::string& folder, const std::string& name, const std::string& script);

}  // namespace physmas::studies

#endif
