// What the stability study leaves: stability.csv (every run), stability.json (counts), heat maps.
#ifndef PHYSMAS_STUDIES_STABILITY_REPORT_H
#define PHYSMAS_STUDIES_STABILITY_REPORT_H

#include "records/provenance.h"
#include "studies/stability.h"

namespace physmas::studies {

struct StabilityCount {
  std::string study, rule, precision;
  long runs = 0, stable = 0, diverged = 0, garbage = 0;
  long long latest = 0;   // substeps to the detection of a divergence, at most
  double most_apart = 0;  // cells, of stable runs
};

// One line per study, rule and precision, in the order of the runs.
std::vector<StabilityCount> count_stability(const std::vector<StabilityRun>& runs);

// Writes into `folder`, which is created. seconds: run time of the study. Plots need gnuplot; without it a warning says
// so. The maps show the runs of the sweep in float, next to where the paper's step equals the limits of
// docs/numerics.md.
void write_stability(const std::string& folder, const std::vector<StabilityRun>& runs, const PaperStep& paper_step,
                     double seconds, const Provenance& provenance);

}  // namespace physmas::studies

#endif
