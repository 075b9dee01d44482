// Small plots of values over time, as SVG in a page.
#ifndef PHYSMAS_REPORT_PLOT_H
#define PHYSMAS_REPORT_PLOT_H

#include <string>
#include <vector>

namespace physmas::report {

struct Curve {
  std::string name;
  std::vector<double> values;  // one per time; not finite: a gap
};

// Curves over `times` [s], with axes, a legend and the last values in words for those who do not see it. unit: of the
// values. Empty where there is nothing to draw.
std::string line_plot(const std::string& title, const std::string& unit, const std::vector<double>& times,
                      const std::vector<Curve>& curves);

struct Bar {
  std::string name, text;  // text: behind the bar
  double start = 0, length = 0;
};
// Bars that begin where the one before ends, or at their own start, with the whole as the width.
std::string bar_plot(const std::string& title, const std::vector<Bar>& bars);

}  // namespace physmas::report

#endif
