#include "report/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "base/file.h"
#include "base/log.h"
#include "records/script_json.h"
#include "remote/base64.h"
#include "report/page.h"
#include "report/run_sections.h"
#include "report/viewer.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "screen/run_table.h"
#include "splat/video.h"
#include "splat/video_cameras.h"

namespace fs = std::filesystem;

namespace physmas::report {
namespace {

constexpr int kStills = 4;
constexpr int kStillWidth = 200;  // pixels

struct Still {
  double time = 0;  // s
  std::string address;
};

// Pictures at kStills equal steps of a video of `count` frames, the first and the last among them.
std::vector<Still> stills_of(const std::string& video, int width, long count) {
  splat::VideoReader reader(video);
  std::vector<Still> stills;
  Image frame;
  for (long t = 0; t < count && reader.next(&frame); ++t) {
    if (static_cast<long>(stills.size()) * (count - 1) / (kStills - 1) != t) continue;
    const int height = std::max(1, frame.height * width / std::max(1, frame.width));
    const double fps = reader.info().fps > 0 ? reader.info().fps : 25;
    stills.push_back(
        {static_cast<double>(t) / fps, data_address("image/jpeg", encode_jpeg(fit_into(frame, width, height), 82))});
    if (stills.size() == kStills) break;
  }
  return stills;
}

std::string video_markup(const std::string& address, const std::string& poster, const std::string& label,
                         const char* kind) {
  return fmt::format(
      "<video class=\"{}\" controls loop muted playsinline preload=\"metadata\" poster=\"{}\" aria-label=\"{}\" "
      "src=\"{}\"></video>\n",
      kind, poster, escaped(label), escaped(address));
}

class Report {
 public:
  explicit Report(const ReportOptions& options) : options_(options) {
    if (!options.failed.empty()) {
      failure_ = read_stage_failure(join_path(options.run, ".stamps/" + options.failed)).value_or(StageFailure());
      if (failure_->code == 0) failure_->code = options.status;
    }
    try {
      run_ = load_run(options.run);
      load_shown();
    } catch (const Error&) {
      // What failed may be what cannot be read.
      if (!failure_) throw;
      run_ = load_request(options.run);
    }
  }

  void write() {
    if (!run_.scene) return write_failure();
    Page page;
    page.title = run_.scene->name + ": " + verdict();
    page.styles = {"page.css", "viewer.css", "report.css"};
    page.scripts = {"viewer.js", "report.js"};
    const Gaussians* gaussians = gaussians_ ? &*gaussians_ : nullptr;
    const std::string sections = first() + candidates() + viewer() + parts_section(run_, gaussians) +
                                 scores_section(run_) + plots_section(run_, rollout_.get()) + error_section(run_) +
                                 omitted_section(run_) + times_section(run_) + provenance_section(run_);
    page.body = head(sections) + "<main>\n" + sections + "</main>\n";
    write_file(options_.out, page_text(page));
    save();
  }

 private:
  // Nothing is there but the words.
  void write_failure() {
    const std::string name = fs::path(fs::absolute(options_.run)).lexically_normal().filename().string();
    Page page;
    page.title = name + ": failed";
    page.styles = {"page.css", "report.css"};
    page.body = fmt::format(
        "<header><p class=\"name\">{} <span class=\"chip bad\">failed</span></p><h1>{}</h1></header>\n<main><section "
        "class=\"first\"><div>{}</div></section></main>\n",
        escaped(name), escaped(name), failure_section(run_, *failure_, options_.failed));
    write_file(options_.out, page_text(page));
    save();
  }

  std::string verdict() const {
    if (failure_) return "failed";
    if (!run_.screen || run_.screen->decision == "repair") return "not finished";
    return run_.accepted.empty() ? "nothing accepted" : "accepted";
  }

  // What the viewer and the plots need.
  void load_shown() {
    if (!run_.state) return;
    SceneNeeds needs;
    needs.gaussians = needs.output_cameras = true;
    scene_ = load_scene(run_.path("spec/render.json"), needs);
    gaussians_ = load_labelled_gaussians(scene_->gaussians, *run_.state, run_.path("state.h5"));
    if (run_.shown == nullptr || !run_.shown->execution) return;
    const std::string file = "rollouts/" + run_.shown->candidate.id + ".h5";
    std::error_code ignored;
    if (!fs::exists(run_.path(file), ignored)) return;
    load_execution_of(run_.path(file));  // the one that was recorded
    run_.files.push_back(file);
    rollout_ = std::make_unique<RolloutReader>(run_.path(file), run_.state->carrier_count());
    frames_ = std::make_unique<splat::RolloutFrames>(run_.path(file), *run_.state);
  }

  // sections: what its links may lead to.
  std::string head(const std::string& sections) const {
    const std::string state = failure_                                            ? "bad"
                              : !run_.screen || run_.screen->decision == "repair" ? "warn"
                              : run_.accepted.empty()                             ? "bad"
                                                                                  : "good";
    std::string nav;
    for (const auto& [id, text] :
         {std::pair("candidates", "Candidates"), std::pair("viewer-section", "In 3D"), std::pair("parts", "Parts"),
          std::pair("scores", "Scores"), std::pair("motion", "Motion"), std::pair("provenance", "Do it again")})
      if (sections.find(fmt::format("<section id=\"{}\"", id)) != std::string::npos)
        nav += fmt::format("<a href=\"#{}\">{}</a>", id, text);
    return fmt::format(
        "<header><p class=\"name\">{} <span class=\"chip {}\">{}</span></p><h1>{}</h1><nav "
        "aria-label=\"Sections\">{}</nav></header>\n",
        escaped(run_.scene->name), state, verdict(),
        escaped(run_.prompt.empty() ? run_.scene->name : "“" + run_.prompt + "”"), nav);
  }

  std::string first() {
    std::string html, why;
    if (failure_) {
      why = failure_section(run_, *failure_, options_.failed);
    } else if (!run_.screen) {
      why =
          "<p class=\"warn\">This run has no screen record: a stage failed, or it was interrupted. What was made so "
          "far is below; <code>make run</code> with the same variables goes on.</p>\n";
    } else if (run_.accepted.empty()) {
      why = "<p><b>No candidate was admitted.</b> " + escaped(run_.screen->reason) + ".</p>\n";
      if (run_.shown != nullptr && run_.shown->screened != nullptr) {
        why += "<p>Shown is the best that has a video, <b>" + escaped(plain_id(run_.shown->candidate.id)) +
               "</b>. It was refused because:</p>\n<ul>";
        for (const ScreenedCandidate::Gate& gate : run_.shown->screened->gates) {
          if (!gate.passed) why += "<li><b>" + escaped(gate.name) + "</b>: " + escaped(gate.advice) + "</li>";
        }
        if (!run_.shown->screened->advice.empty())
          why += "<li><b>score</b>: " + escaped(run_.shown->screened->advice) + "</li>";
        why += "</ul>\n";
      }
    } else {
      why = fmt::format("<p><b>{}</b> was accepted: {}a score Q of {:.2f}, where {:g} is needed.</p>\n",
                        escaped(plain_id(run_.accepted)),
                        run_.attempts.size() > 1 ? fmt::format("the best of {} candidates, with ", run_.attempts.size())
                                                 : std::string(),
                        run_.shown->screened != nullptr ? run_.shown->screened->score : 0, run_.screen->tau);
    }
    if (!run_.shown_video.empty()) {
      const std::string path = run_.path(run_.shown_video);
      const std::vector<Still> stills = stills_of(path, 640, run_.scene->run.time.frames);
      html += video_markup(data_address("video/mp4", read_file(path)),
                           stills.empty() ? "data:," : stills.front().address, "The video of this run", "shown");
    }
    return "<section class=\"first\">" + html + "<div>" + why + actions_section(run_) + "</div></section>\n";
  }

  std::string candidates() {
    std::string html;
    size_t total = 0;
    bool beside = false;  // some videos are files beside the page
    for (const RunRecords::Attempt& a : run_.attempts) {
      const std::string id = a.candidate.id;
      std::string state = "–", kind = "";
      if (a.screened != nullptr) {
        state = id == run_.accepted    ? "accepted"
                : a.screened->admitted ? "admitted"
                : a.screened->valid    ? "below τ"
                                       : "refused";
        kind = a.screened->admitted ? "good" : "bad";
      }
      std::string picture;
      if (!a.video.empty()) {
        const std::vector<Still> stills = stills_of(run_.path(a.video), kStillWidth, a.render->frames_written);
        const size_t size = fs::file_size(run_.path(a.video));
        const bool inside = total + size <= options_.candidate_bytes;
        if (inside) total += size;
        beside |= !inside;
        picture = video_markup(inside ? data_address("video/mp4", read_file(run_.path(a.video))) : a.video,
                               stills.empty() ? "data:," : stills.back().address, plain_id(id), "small");
        picture += "<div class=\"stills\">";
        for (const Still& still : stills)
          picture += fmt::format(
              "<button type=\"button\" data-time=\"{:.3f}\" aria-label=\"Show {} at {:.2f} s\"><img alt=\"\" "
              "src=\"{}\"><span>{:.1f} s</span></button>",
              still.time, escaped(plain_id(id)), still.time, still.address, still.time);
        picture += "</div>";
      } else {
        const std::string why = a.execution && a.execution->diverged
                                    ? (a.execution->divergence ? a.execution->divergence->advice : a.execution->reason)
                                : a.execution ? "It has no video."
                                              : "It was not simulated.";
        picture = "<div class=\"no-video\"><p>" + escaped(why) + "</p></div>";
      }
      html += fmt::format(
          "<article class=\"card\"><h3>{} <span class=\"chip {}\">{}</span></h3>{}<p "
          "class=\"quiet\">{}</p></article>\n",
          escaped(plain_id(id)), kind, state, picture,
          a.screened != nullptr
              ? fmt::format("Q {:.3f}, rank {}{}", a.screened->score, a.screened->rank,
                            a.screened->achieved ? fmt::format(", achieved {:.0f} %", 100 * *a.screened->achieved)
                                                 : std::string())
              : std::string("not screened"));
    }
    if (html.empty()) return "";
    if (beside)
      omitted_.push_back({"videos of some candidates",
                          "together they are too large for the page; they are played from the run's folder"});
    const bool has_video =
        std::any_of(run_.attempts.begin(), run_.attempts.end(), [](const auto& a) { return !a.video.empty(); });
    return std::string("<section id=\"candidates\"><h2>What was tried</h2>\n") +
           (has_video ? "<p><button type=\"button\" id=\"play-all\">Play all together</button></p>\n" : "") +
           "<div class=\"cards\">" + html + "</div></section>\n";
  }

  std::string viewer() {
    if (options_.viewer_bytes == 0 || !frames_ || frames_->count() < 1) return "";
    const ExecutionRecord& execution = *run_.shown->execution;
    std::string cameras;
    for (int n = 0; n < 3; ++n) {
      const std::string file = fmt::format("cameras/round{}.json", n);
      std::error_code ignored;
      if (n == run_.shown->candidate.round && fs::exists(run_.path(file), ignored)) cameras = file;
    }
    if (!cameras.empty()) run_.files.push_back(cameras);
    const FittedCameras shown = splat::video_cameras(*scene_, *run_.state, *gaussians_, *frames_, execution,
                                                     cameras.empty() ? "" : run_.path(cameras));
    StreamLimits limits;
    limits.bytes = options_.viewer_bytes;
    limits.gaussians = std::min(limits.gaussians, options_.viewer_bytes / 16);
    Viewer made = make_viewer({*scene_, *run_.state, *gaussians_, *frames_, shown, &*run_.inventory,
                               &run_.shown->candidate, execution.candidate},
                              limits);
    made.header["page"] = true;
    viewer_ = {{"gaussians", made.header.at("gaussians")},
               {"frames", made.header.at("frames").size()},
               {"bytes", made.bytes.size()}};
    return "<section id=\"viewer-section\"><h2>In 3D</h2>\n<p class=\"quiet\">Drag to turn, pinch or scroll to come "
           "nearer, and choose what the colours show. " +
           escaped(made.about) + "</p>\n<div id=\"viewer\"></div>\n<script type=\"application/json\" id=\"header\">" +
           script_json(made.header) + "</script>\n<script type=\"text/plain\" id=\"stream\">" +
           remote::base64_of(made.bytes) + "</script>\n</section>\n";
  }

  void save() const {
    Json ids = Json::array();
    for (const RunRecords::Attempt& a : run_.attempts) ids.push_back(a.candidate.id);
    const bool finished = run_.screen && run_.screen->decision != "repair";
    const Json body = {
        {"page", fs::path(options_.out).filename().string()},
        {"decision", finished ? run_.screen->decision : "unfinished"},
        {"shown", run_.shown != nullptr ? Json(run_.shown->candidate.id) : Json(nullptr)},
        {"candidates", ids},
        {"viewer", viewer_},
        {"failed", failure_
                       ? Json({{"stage", options_.failed}, {"status", failure_->code}, {"message", failure_->message}})
                       : Json(nullptr)},
        {"omitted", to_json(omitted_)}};
    Provenance provenance;
    provenance.tool = "pm-report";
    for (const std::string& file : run_.files) provenance.add_input(run_.path(file));
    provenance.add_output(options_.out);
    save_record(fs::path(options_.out).replace_extension(".json").string(), "report", provenance, body);
  }

  ReportOptions options_;
  std::optional<StageFailure> failure_;
  RunRecords run_;
  std::optional<Scene> scene_;
  std::optional<Gaussians> gaussians_;
  std::unique_ptr<RolloutReader> rollout_;
  std::unique_ptr<splat::RolloutFrames> frames_;
  Json viewer_ = nullptr;
  std::vector<Omission> omitted_;
};

}  // namespace

void write_run_report(const ReportOptions& options) {
  Report(options).write();
}

void write_run_index(const std::vector<std::string>& runs, const std::string& out) {
  const std::string folder = folder_of(out);
  std::string rows;
  int accepted = 0;
  for (const std::string& path : runs) {
    const screen::RunSummary run = screen::summarise_run(path);
    accepted += run.result == "accepted";
    std::string picture, prompt, report;
    std::error_code ignored;
    const std::string there = fs::relative(path, folder, ignored).generic_string();
    for (const char* video : {"final.mp4", "best.mp4"}) {
      if (!picture.empty() || !fs::exists(join_path(path, video), ignored)) continue;
      try {
        const std::vector<Still> stills =
            stills_of(join_path(path, video), 160, splat::count_decodable_frames(join_path(path, video)));
        if (!stills.empty()) picture = "<img alt=\"\" src=\"" + stills.back().address + "\">";
      } catch (const Error&) {
        // The row's result says what is wrong with the run.
      }
    }
    try {
      const Json plan = load_record(join_path(path, "plan.json"), "plan");
      prompt = plan.at("prompt").get<std::string>();
    } catch (const Error&) {
    }
    // Of a run that failed: as far as it came.
    if (!fs::exists(join_path(path, "report.html"), ignored) &&
        fs::exists(join_path(path, "spec/render.json"), ignored)) {
      try {
        ReportOptions options;
        options.run = path;
        options.out = join_path(path, "report.html");
        write_run_report(options);
      } catch (const Error& e) {
        log_warning(e.what());
      }
    }
    const bool has_report = fs::exists(join_path(path, "report.html"), ignored);
    const std::string name = escaped(run.name);
    rows += fmt::format(
        "<tr><td class=\"still\">{}</td><th scope=\"row\">{}<small>{}</small></th><td><span class=\"chip "
        "{}\">{}</span></td><td>{}</td><td class=\"n\">{:.2f}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
        picture, has_report ? file_link(there + "/report.html", name) : name, escaped(prompt),
        run.result == "accepted" ? "good"
        : run.result == "failed" ? "warn"
                                 : "bad",
        escaped(run.result), escaped(run.candidate.empty() ? "–" : plain_id(run.candidate)), run.score,
        std::string(kPageRuntime[0]) + (run.seconds > 0 ? fmt::format("{:.0f} s", run.seconds) : "–") +
            std::string(kPageRuntime[1]),
        escaped(run.reason));
  }
  Page page;
  page.title = fmt::format("{} of {} runs accepted", accepted, runs.size());
  page.styles = {"page.css", "report.css"};
  page.body = fmt::format(
      "<header><p class=\"name\">PhysMAS</p><h1>{}</h1></header><main><section><div class=\"scroll\"><table "
      "class=\"index\"><thead><tr><th></th><th>Scene</th><th>Result</th><th>Candidate</th><th>Q</th><th>Time</"
      "th><th>Reason</th></tr></thead><tbody>\n{}</tbody></table></div></section></main>\n",
      page.title, rows);
  write_file(out, page_text(page));
}

}  // namespace physmas::report
