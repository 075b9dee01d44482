// The registered benchmark as files: what make needs of a suite, and the evaluation that its results make.
#ifndef PHYSMAS_TABLES_SUITE_H
#define PHYSMAS_TABLES_SUITE_H

#include <string>
#include <vector>

#include "records/json_fwd.h"
#include "records/suite.h"

namespace physmas::tables {

// Makefile variables (pipelines/evaluate.mk says which) for the cases with these ids; all of them when there are none.
// An unknown id is a usage error.
std::string suite_makefile(const Suite& suite, const std::vector<std::string>& ids);

// The evaluation record, without its schema, of the results in the folder `evaluation`: results/CASE/METHOD/result.tsv
// is one line,
//   done <tab> candidate <tab> seconds      with motion-OBJECT.json for every object beside it, and the run in
//   CASE/METHOD; or failed <tab> reason
// A result without that file, or with another line in it, is a failure that says so: no case is dropped.
// ids: as above.
Json collect_evaluation(const Suite& suite, const std::string& evaluation, const std::vector<std::string>& ids);

}  // namespace physmas::tables

#endif
