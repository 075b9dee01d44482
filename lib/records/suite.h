// suite.json: a registered benchmark, written by the user; and suite.sha256 beside it, which fixes it by hash.
#ifndef PHYSMAS_RECORDS_SUITE_H
#define PHYSMAS_RECORDS_SUITE_H

#include <map>
#include <string>
#include <vector>

namespace physmas {

struct SuiteMethod {
  std::string id, name;
  std::vector<std::string> settings;  // KEY=VALUE, added to the suite's
  std::string candidate;              // whose rollout is the result; empty: the accepted one's
};

struct SuiteCase {
  std::string id;
  bool multi_object = false;
  std::string example, reference;               // paths relative to the working folder
  std::string prompt;                           // the example's
  std::vector<std::string> objects;             // what is measured
  std::vector<std::string> profiles;            // branches of the reference's rows, in the order of the profiles
  std::vector<std::string> reference_settings;  // of the reference alone
  std::string key;                              // 16 digits of the hash of all that shapes its reference
};

struct Suite {
  std::string path;
  std::vector<std::string> settings;
  std::vector<SuiteMethod> methods;  // the first computes what the others share
  std::vector<std::string> comparison, required;
  std::vector<SuiteCase> cases;
  std::map<std::string, std::string>
      hashes;  // SHA-256 of the suite, its examples and references, relative to its folder
};

// Reads the suite, its examples and its references. Errors (exit code 3): ids that occur twice or do not resolve, a
// file outside the suite's folder, a multi-part case with other than one object, a reference without exactly the rows
// of its example, an object that the example lacks.
Suite load_suite(const std::string& path);

// Refuses (exit code 3) a suite of which a file is not as suite.sha256 has it, or not in there: names the file, and how
// to register it again.
void require_registered(const Suite& suite);

// Writes suite.sha256, in the form of sha256sum.
void register_suite(const Suite& suite);

}  // namespace physmas

#endif
