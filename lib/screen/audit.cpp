#include "screen/audit.h"

#include <filesystem>
#include <set>

#include "records/json.h"
#include "splat/video.h"

namespace physmas::screen {

namespace {

// Frames of the video after decoding all of them, or the decoder's complaint, without the path that it starts with.
Json decoded_frames(const std::string& video) {
  try {
    return splat::count_decodable_frames(video);
  } catch (const Error& e) {
    const std::string text = e.what(), prefix = video + ": ";
    return text.rfind(prefix, 0) == 0 ? text.substr(prefix.size()) : text;
  }
}

}  // namespace

void audit_accepted(ScreenRecord& record, const Executed& executed, const SceneRecords& scene,
                    const std::string& video) {
  std::error_code failure;
  const bool exists = !video.empty() && std::filesystem::is_regular_file(video, failure);
  const Json frames = exists ? decoded_frames(video) : Json(0);
  std::set<std::string> objects;
  for (const CandidateRow& row : executed.candidate.rows) objects.insert(scene.inventory.rows[row.row].object);
  const bool several = objects.size() > 1;
  const size_t bonds = executed.candidate.retention.size();

  record.audited = true;
  record.audit = {
      {"video exists", exists, exists, true},
      {"decodable frames", frames == scene.frames, frames, scene.frames},
      {"bonded interfaces", !several || bonds == 0, bonds, several ? Json(0) : Json("any: the scene has one object")}};
  record.audit_passed = true;
  for (const AuditCheck& check : record.audit) {
    if (check.passed) continue;
    record.audit_passed = false;
    record.decision = "fail";
    record.reason = record.accepted + " failed its audit: " + check.name + ": found " + check.measured.dump() +
                    ", expected " + check.expected.dump();
    record.accepted.clear();
    return;
  }
}

}  // namespace physmas::screen
