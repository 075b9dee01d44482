// The sections of a run's page, each as markup; empty where there is nothing to say.
#ifndef PHYSMAS_REPORT_RUN_SECTIONS_H
#define PHYSMAS_REPORT_RUN_SECTIONS_H

#include <string>

#include "records/rollout.h"
#include "report/run_records.h"
#include "scene/gaussians.h"

namespace physmas::report {

// A candidate's id as a person reads it.
std::string plain_id(const std::string& id);
// A number with a unit's prefix: "1.2 MPa".
std::string with_prefix(double value, const char* unit);
// A link to a file of the run.
std::string file_link(const std::string& file, const std::string& text);

std::string actions_section(const RunRecords& run);
// gaussians: null where they could not be read; then without pictures.
std::string parts_section(const RunRecords& run, const Gaussians* gaussians);
std::string scores_section(const RunRecords& run);
// rollout: of the shown candidate, with its velocities; null: none.
std::string plots_section(const RunRecords& run, RolloutReader* rollout);
std::string error_section(const RunRecords& run);  // of the accepted run's discretisation, where it was estimated
std::string omitted_section(const RunRecords& run);
std::string times_section(const RunRecords& run);  // between kPageRuntime
// Markup without a section of its own. stage: as make calls it.
std::string failure_section(const RunRecords& run, const StageFailure& failure, const std::string& stage);
std::string provenance_section(const RunRecords& run);

}  // namespace physmas::report

#endif
