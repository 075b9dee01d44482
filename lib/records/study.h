// Records of a blinded forced-choice study: key.json, the answers of respondents, upr.json.
#ifndef PHYSMAS_RECORDS_STUDY_H
#define PHYSMAS_RECORDS_STUDY_H

#include <map>
#include <string>
#include <vector>

#include "records/provenance.h"

namespace physmas {

struct StudyKey {
  struct Case {
    std::string id;
    bool multi_object = false;
    std::vector<std::string> profiles;
    std::map<std::string, std::string> codes;  // code on the page -> method id
  };
  std::string study;  // "comparison" or "ablation"
  std::string token;  // ties answers to this key
  std::vector<std::string> methods;
  std::vector<Case> cases;
};
StudyKey load_study_key(const std::string& path);
void save_study_key(const std::string& path, const StudyKey& key, const Provenance& provenance);

struct StudyAnswers {
  struct Answer {
    std::string case_id;
    std::string method;  // the chosen one
  };
  std::string respondent;
  std::vector<Answer> answers;
};
// Errors (exit code 3): answers to another study, cases or codes that the key does not know, a case answered twice, a
// choice that was not on the screen.
StudyAnswers load_study_answers(const std::string& path, const StudyKey& key);

struct Preference {
  double value = 0, low = 0, high = 0;  // percent; 95 % percentile interval
};

struct UprRecord {
  struct Case {
    std::string id;
    long responses = 0;                  // R_c
    std::map<std::string, long> counts;  // method id -> responses that chose it
  };
  struct Set {
    std::string name;
    long cases = 0;
    std::map<std::string, Preference> upr;  // by method id
  };
  std::string study;
  std::vector<std::string> methods;
  long respondents = 0, resamples = 0, seed = 0;
  std::vector<Case> cases;
  std::vector<Set> sets;
};
UprRecord load_upr(const std::string& path);
void save_upr(const std::string& path, const UprRecord& record, const Provenance& provenance);

}  // namespace physmas

#endif
