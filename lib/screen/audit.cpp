#include "screen/audit.h"

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <set>

namespace physmas::screen {

int count_decodable_frames(const std::string& path) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure)) return 0;
  cv::VideoCapture capture(path, cv::CAP_FFMPEG);
  int count = 0;
  cv::Mat frame;
  while (capture.isOpened() && capture.read(frame)) ++count;
  return count;
}

void audit_accepted(ScreenRecord& record, const Executed& executed, const SceneRecords& scene,
                    const std::string& video) {
  std::error_code failure;
  const bool exists = !video.empty() && std::filesystem::is_regular_file(video, failure);
  const int frames = exists ? count_decodable_frames(video) : 0;
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
