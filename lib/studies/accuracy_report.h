// The accuracy study as files: JSON, CSV and plots.
#ifndef PHYSMAS_STUDIES_ACCURACY_REPORT_H
#define PHYSMAS_STUDIES_ACCURACY_REPORT_H

#include <string>
#include <vector>

#include "records/provenance.h"
#include "studies/accuracy.h"

namespace physmas::studies {

// Writes accuracy.json, accuracy.csv, accuracy.gp and, where gnuplot is installed, accuracy-METRIC.png into `folder`.
// command: as the user typed it.
void write_accuracy(const std::string& folder, const std::vector<AccuracyStudy>& studies, const AccuracyPlan& plan,
                    const std::string& command, const Provenance& provenance);

// The Pareto-optimal settings of the particle-position error, as a table for people.
std::string accuracy_table(const std::vector<AccuracyStudy>& studies);

}  // namespace physmas::studies

#endif
