// evaluation.json: the methods and cases of an evaluation, and where their results lie. Written by the user.
#ifndef PHYSMAS_RECORDS_EVALUATION_H
#define PHYSMAS_RECORDS_EVALUATION_H

#include <map>
#include <string>
#include <vector>

namespace physmas {

struct EvaluationMethod {
  std::string id;
  std::string name;  // in tables
};

struct EvaluationResult {
  bool done = false;
  std::string reason;                // why not
  std::string video;                 // path, empty when the manifest names none
  std::vector<std::string> metrics;  // paths of metrics.json records
  double seconds = 0;                // run time after reconstruction; 0: not stated
};

struct EvaluationCase {
  std::string id;
  bool multi_object = false;
  std::string prompt;
  std::vector<std::string> profiles;                // names of branches; empty for a multi-object case
  std::vector<std::string> objects;                 // registered objects; empty for a multi-part case
  std::map<std::string, EvaluationResult> results;  // by method id: one of every method of a table
};

struct Evaluation {
  std::string path;  // of the manifest, for messages
  std::vector<EvaluationMethod> methods;
  std::vector<std::string> comparison, ablation;  // method ids, in the order of the tables; ablation may be empty
  std::vector<std::string> required;              // metrics that every case of a table must have
  std::vector<EvaluationCase> cases;
  const std::string& method_name(const std::string& id) const;
};

// Paths in the result are relative to the working folder. A method of a table without a result in a case gets a failure
// "no result". Errors (exit code 3): ids that occur twice or do not resolve, a multi-part case without profiles, a
// multi-object case without objects, paths that leave the manifest's folder.
Evaluation load_evaluation(const std::string& path);

}  // namespace physmas

#endif
