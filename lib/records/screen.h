// screen/roundN.json: features, gates, scores, ranking, decision; and accepted.json.
#ifndef PHYSMAS_RECORDS_SCREEN_H
#define PHYSMAS_RECORDS_SCREEN_H

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "records/json.h"

namespace physmas {

// The repairs that a screen may ask for, in the paper's fixed order. A repair's id is base id, hyphen, name.
inline constexpr std::array<const char*, 6> kRepairNames = {"support-stiffness", "rigid-support",    "elastic-cohesion",
                                                            "higher-cohesion",   "solver-stability", "role-balanced"};

struct ScreenedCandidate {
  struct Gate {
    std::string name;  // plan | process | numerical | spread | flattening | support | achieved | stillness
    bool passed = false;
    Json measured, limit;
    std::string advice = {};  // one sentence for a person, of a failed gate
  };
  std::string id, transform;
  int order = 0, round = 0;
  // phi(k), paper Eq. (supp-critic)
  double video = 0, part_confidence = 0, diversity = 0, role = 0, base = 0, density = 0, solver = 0;
  std::vector<std::pair<std::string, double>> video_terms;
  double penalty = 0;  // l(k)
  double score = 0;    // Q_exec(k)
  // Beside Q, no part of it; none: the plan has no action, or nothing was to stand still.
  std::optional<double> achieved;   // 0..1: the smallest share of a request that an action met
  std::optional<double> stillness;  // 0..1, of what nothing moved or touched
  std::vector<Gate> gates;
  bool valid = false;     // all gates passed
  bool admitted = false;  // valid and score >= tau
  int rank = 0;           // 1 is the best of all executed
  std::string advice;     // valid, but below tau: one sentence for a person
};

struct AuditCheck {
  std::string name;
  bool passed = false;
  Json measured, expected;
};

struct ScreenRecord {
  int round = 0;
  double tau = 0.72;
  std::vector<double> weights;                // w of Eq. supp-critic, in the order of phi
  std::vector<ScreenedCandidate> candidates;  // order of first appearance
  std::string decision;                       // accept | repair | fail
  std::string reason;
  std::string accepted;                    // id, empty when none
  std::string repair_base;                 // id, empty when the decision is not repair
  std::vector<std::string> repair_routes;  // repairs that the base's diagnostics ask for, fixed order
  bool audited = false;
  bool audit_passed = false;
  std::vector<AuditCheck> audit;
  std::vector<Omission> omitted;
};

ScreenRecord load_screen(const std::string& path);
void save_screen(const std::string& path, const ScreenRecord& record, const Provenance& provenance);

// accepted.json: the accepted candidate of a run.
struct AcceptedRecord {
  std::string candidate;
  int round = 0;
  double score = 0;
  std::string video;
  int frames = 0;
  std::vector<std::pair<std::string, std::string>> audit;  // role -> file relative to the record
};
void save_accepted(const std::string& path, const AcceptedRecord& record, const Provenance& provenance);
AcceptedRecord load_accepted(const std::string& path);

}  // namespace physmas

#endif
