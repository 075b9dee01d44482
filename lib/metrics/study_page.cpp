#include "metrics/study_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/embedded_text.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "records/json.h"
#include "records/script_json.h"
#include "splat/video.h"

namespace physmas::metrics {
namespace {

constexpr size_t kCodeLength = 12;
constexpr size_t kMaxCards = 9;  // one key each

}  // namespace

StudyKey make_study(const Evaluation& evaluation, const std::string& study, const std::string& seed) {
  StudyKey key;
  key.study = study;
  key.methods = study == "ablation" ? evaluation.ablation : evaluation.comparison;
  if (key.methods.size() < 2 || key.methods.size() > kMaxCards)
    throw invalid_input({evaluation.path, "/" + study, fmt::format("{} methods", key.methods.size()),
                         fmt::format("2 to {} to choose from", kMaxCards)});
  std::string all = seed + "\n" + study;
  for (const EvaluationCase& c : evaluation.cases) {
    StudyKey::Case entry{c.id, c.multi_object, c.profiles, {}};
    for (const std::string& method : key.methods) {
      const std::string code =
          sha256_text(fmt::format("{}\n{}\n{}\n{}", seed, study, c.id, method)).substr(0, kCodeLength);
      if (!entry.codes.emplace(code, method).second) throw internal_error("two results have the code " + code);
      all += "\n" + code;
    }
    key.cases.push_back(std::move(entry));
  }
  key.token = sha256_text(all);
  return key;
}

void write_study_page(const std::string& folder, const Evaluation& evaluation, const StudyKey& key) {
  Json json = {{"token", key.token}, {"trials", Json::array()}};
  for (size_t i = 0; i < key.cases.size(); ++i) {
    const EvaluationCase& c = evaluation.cases[i];
    Json cards = Json::array();
    splat::VideoInfo first;
    // A map is in the order of codes, which says nothing about methods.
    for (const auto& [code, method] : key.cases[i].codes) {
      const EvaluationResult& result = c.results.at(method);
      cards.push_back({{"code", code}, {"video", result.done}});
      if (!result.done) continue;
      if (result.video.empty())
        throw invalid_input({evaluation.path, fmt::format("case \"{}\", method \"{}\"", c.id, method), "no video",
                             "the video of a result that is done"});
      const splat::VideoInfo info = splat::decode_video(result.video);
      if (first.frames == 0) first = info;
      if (info.frames != first.frames || info.fps != first.fps)
        log_warning(fmt::format("case \"{}\": a video of {} frames at {:g} per second beside one of {} at {:g}", c.id,
                                info.frames, info.fps, first.frames, first.fps));
      write_file(fmt::format("{}/page/videos/{}.mp4", folder, code), read_file(result.video));
    }
    // All cards of a case have one shape, whatever the shapes of their videos.
    const double aspect = first.height > 0 ? static_cast<double>(first.width) / first.height : 1;
    json["trials"].push_back({{"case", c.id}, {"prompt", c.prompt}, {"aspect", aspect}, {"cards", cards}});
  }
  std::string page = embedded_text("lib/metrics/pages/study.html");
  const std::string place = "@STUDY@";
  page.replace(page.find(place), place.size(), script_json(json));
  write_file(folder + "/page/index.html", page);
}

}  // namespace physmas::metrics
