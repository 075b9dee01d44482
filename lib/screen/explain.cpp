#include "screen/explain.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "records/json.h"

namespace physmas::screen {
namespace {

std::vector<const ScreenedCandidate*> by_rank(const ScreenRecord& record) {
  std::vector<const ScreenedCandidate*> candidates;
  for (const ScreenedCandidate& c : record.candidates) candidates.push_back(&c);
  std::sort(candidates.begin(), candidates.end(), [](const auto* a, const auto* b) { return a->rank < b->rank; });
  return candidates;
}

// "exit 0, signal 0" for {"exit": 0, "signal": 0}.
std::string plain(const Json& value) {
  if (value.is_null()) return "not measured";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_object()) return value.dump();
  std::string text;
  for (const auto& [key, part] : value.items()) text += (text.empty() ? "" : ", ") + key + " " + plain(part);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string share(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : "-";
}

const char* verdict(const ScreenedCandidate& candidate, double tau) {
  if (candidate.admitted) return "admitted";
  if (!candidate.valid) return candidate.score < tau ? "gate, score" : "gate";
  return "score";
}

}  // namespace

std::string explain(const ScreenRecord& record) {
  const auto candidates = by_rank(record);
  size_t width = 9;
  for (const auto* c : candidates) width = std::max(width, c->id.size());
  std::string text =
      fmt::format("round {}, tau {}: {} - {}\n\n", record.round, record.tau, record.decision, record.reason);
  if (!record.weights.empty()) text += fmt::format("weights {}\n", fmt::join(record.weights, " "));
  text += fmt::format(
      "rank  {:<{}}       Q  achieved  still   video    part    div.    role    base  densi.  solver  penal.  "
      "verdict\n",
      "candidate", width);
  for (const auto* c : candidates) {
    text += fmt::format(
        "{:>4}  {:<{}}  {:6.4f}  {:>8}  {:>5}  {:6.3f}  {:6.4f}  {:6.4f}  {:6.4f}  {:6.4f}  {:6.4f}  {:6.4f}  {:6.4f}  "
        "{}\n",
        c->rank, c->id, width, c->score, share(c->achieved), share(c->stillness), c->video, c->part_confidence,
        c->diversity, c->role, c->base, c->density, c->solver, c->penalty, verdict(*c, record.tau));
  }
  for (const auto* c : candidates) {
    text += fmt::format("\n{} (round {}, {})\n", c->id, c->round, c->transform);
    for (const auto& [term, value] : c->video_terms) text += fmt::format("  video       {:+.2f}  {}\n", value, term);
    for (const ScreenedCandidate::Gate& gate : c->gates) {
      text += fmt::format("  {:<10}  {}  {}; limit: {}\n", gate.name, gate.passed ? "pass  " : "FAILED",
                          plain(gate.measured), plain(gate.limit));
      if (!gate.advice.empty()) text += fmt::format("              {}\n", gate.advice);
    }
    if (!c->advice.empty())
      text += fmt::format("  {:<10}  FAILED  {:.4f}; limit: {}\n              {}\n", "score", c->score, record.tau,
                          c->advice);
  }
  if (!record.repair_base.empty()) {
    text += fmt::format("\nrepair {}:", record.repair_base);
    for (const std::string& route : record.repair_routes) text += " " + route;
    text += '\n';
  }
  if (record.audited) {
    text += fmt::format("\naudit {}\n", record.audit_passed ? "passed" : "FAILED");
    for (const AuditCheck& check : record.audit) {
      text += fmt::format("  {:<18}  {}  {}; expected: {}\n", check.name, check.passed ? "pass  " : "FAILED",
                          plain(check.measured), plain(check.expected));
    }
  }
  return text;
}

}  // namespace physmas::screen
