#include "report/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "base/file.h"
#include "lift/label_picture.h"
#include "records/json.h"
#include "records/script_json.h"
#include "report/page.h"
#include "report/preview_motion.h"
#include "report/run_records.h"
#include "report/run_sections.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "scene/view_pictures.h"
#include "splat/floor_shadow.h"
#include "splat/middle_box.h"
#include "splat/row_colors.h"
#include "splat/video.h"

namespace fs = std::filesystem;

namespace physmas::report {
namespace {

constexpr int kWidth = 640;   // pixels of a view's picture in the page, at most
constexpr size_t kStrip = 4;  // pictures of the coarse motion

// Lines and arrows over a view, in its pixels.
class Overlay {
 public:
  explicit Overlay(const Camera& camera) : camera_(camera) {}

  void line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const char* kind) {
    const Eigen::Vector3d a = camera_.to_camera(from), b = camera_.to_camera(to);
    if (a.z() <= 0 || b.z() <= 0) return;
    const Eigen::Vector2d p = camera_.project(a), q = camera_.project(b);
    svg_ += fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kind, p.x(),
                        p.y(), q.x(), q.y());
  }
  void arrow(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const char* kind, const std::string& text) {
    const Eigen::Vector3d a = camera_.to_camera(from), b = camera_.to_camera(to);
    if (a.z() <= 0 || b.z() <= 0) return;
    const Eigen::Vector2d p = camera_.project(a), q = camera_.project(b);
    const double head = camera_.width * 0.018;
    if ((q - p).norm() < head) {  // towards whoever looks, or away
      svg_ += fmt::format("<circle class=\"{} head\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>", kind, q.x(), q.y(),
                          head * 0.6);
    } else {
      const Eigen::Vector2d d = (q - p).normalized(), n(-d.y(), d.x()), base = q - d * head;
      svg_ += fmt::format("<line class=\"{}\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", kind, p.x(),
                          p.y(), base.x(), base.y());
      const Eigen::Vector2d left = base + n * head * 0.55, right = base - n * head * 0.55;
      svg_ += fmt::format("<polygon class=\"{} head\" points=\"{:.1f},{:.1f} {:.1f},{:.1f} {:.1f},{:.1f}\"/>", kind,
                          q.x(), q.y(), left.x(), left.y(), right.x(), right.y());
    }
    if (!text.empty())
      svg_ += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:.0f}\">{}</text>", kind,
                          q.x() + head * 0.5, q.y() - head * 0.4, camera_.width * 0.038, escaped(text));
  }
  const std::string& svg() const { return svg_; }

 private:
  const Camera& camera_;
  std::string svg_;
};

std::string name_of(const Inventory& inventory, const std::string& reference) {
  const int r = inventory.find_row(reference), o = inventory.find_object(reference);
  if (r >= 0 && !inventory.rows[static_cast<size_t>(r)].name.empty())
    return inventory.rows[static_cast<size_t>(r)].name;
  return o >= 0 ? inventory.objects[static_cast<size_t>(o)].name : reference;
}

std::string action_words(const PlanAction& action, const RunRecords& run) {
  std::string type = action_name(action.type);
  std::replace(type.begin(), type.end(), '_', ' ');
  std::string text = "<b>" + escaped(type) + "</b> of " + escaped(name_of(*run.inventory, action.target));
  if (!action.source.empty()) text += " by " + escaped(name_of(*run.inventory, action.source));
  if (action.direction.norm() > 0)
    text += fmt::format(", along ({:.2g}, {:.2g}, {:.2g})", action.direction.x(), action.direction.y(),
                        action.direction.z());
  text += is_ratio(action.type) ? fmt::format(", to {:.0f} % of its size", 100 * action.magnitude)
                                : fmt::format(", {:.3g}{}", action.magnitude, action_line(action.type).unit);
  return text + fmt::format(", from {:.2f} s to {:.2f} s", action.start, action.end);
}

class Preview {
 public:
  explicit Preview(const PreviewOptions& options) : options_(options), run_(load_run(options.run)) {}

  void write() {
    if (!run_.inventory || !run_.plan)
      throw invalid_input({options_.run, "", "no inventory.json and plan.json", "a run that was grounded",
                           "make preview RUN=" + options_.run});
    SceneNeeds needs;
    needs.gaussians = needs.output_cameras = true;
    scene_ = load_scene(run_.path("spec/render.json"), needs);
    needs = {};
    needs.views = true;
    views_ = load_scene(run_.path("spec/ground.json"), needs);
    gaussians_ = load_gaussians(scene_.gaussians);
    Page page;
    page.title = run_.scene->name + ": preview";
    page.styles = {"page.css", "report.css", "preview.css"};
    page.scripts = {"preview.js", "preview-edit.js"};
    // One after the other: each adds its pictures to the sheet.
    page.body = header() + "<main>\n";
    page.body += view_section();
    page.body += plan_section();
    page.body += motion_section();
    page.body += mark_section() + material_section() + parts_section(run_, nullptr) + "</main>\n" + data();
    write_file(options_.out, page_text(page));
    const std::string picture = fs::path(options_.out).replace_extension(".png").string();
    save_png(picture, contact_sheet(pictures_, captions_, 4, 320));
    Provenance provenance;
    provenance.tool = "pm-report";
    for (const std::string& file : run_.files) provenance.add_input(run_.path(file));
    provenance.add_output(options_.out);
    provenance.add_output(picture);
    if (!video_.empty()) provenance.add_output(video_);
    save_record(fs::path(options_.out).replace_extension(".json").string(), "report", provenance,
                {{"page", fs::path(options_.out).filename().string()},
                 {"decision", "preview"},
                 {"shown", nullptr},
                 {"candidates", Json::array()},
                 {"viewer", nullptr},
                 {"omitted", to_json(omitted_)}});
  }

 private:
  std::string header() const {
    return fmt::format("<header><p class=\"name\">{} <span class=\"chip\">preview</span></p><h1>“{}”</h1></header>\n",
                       escaped(run_.scene->name), escaped(run_.prompt));
  }

  // Box of an object's or a row's Gaussians; of all where it has none.
  Eigen::AlignedBox3d box_of(const std::string& reference) const {
    if (!run_.state) return splat::middle_box(gaussians_);
    const std::vector<int> rows = resolve_rows(*run_.inventory, reference);
    Gaussians part;
    for (size_t i = 0; i < gaussians_.size(); ++i) {
      if (std::find(rows.begin(), rows.end(), run_.state->gaussian_row[i]) != rows.end())
        part.position.push_back(gaussians_.position[i]);
    }
    if (part.position.empty()) return splat::middle_box(gaussians_);
    return splat::middle_box(part);
  }

  std::string overlay(const Camera& camera) const {
    Overlay over(camera);
    const Eigen::AlignedBox3d box = splat::middle_box(gaussians_);
    const double size = std::max(box.sizes().norm(), 1e-9);
    const Eigen::Vector3d middle = box.center(), up = run_.scene->run.placement.up_vector();
    const SolverMap map = run_.state ? run_.state->map : SolverMap();
    if (run_.state) {
      const splat::FloorPlane floor = splat::floor_plane(run_.scene->run, map, gaussians_);
      const Eigen::Vector3d u = floor.normal.unitOrthogonal(), v = floor.normal.cross(u);
      const Eigen::Vector3d at = middle - floor.normal * floor.normal.dot(middle - floor.point);
      for (int k = -3; k <= 3; ++k) {
        over.line(at + size * (u * k / 4.0 - v * 0.75), at + size * (u * k / 4.0 + v * 0.75), "floor");
        over.line(at + size * (v * k / 4.0 - u * 0.75), at + size * (v * k / 4.0 + u * 0.75), "floor");
      }
    }
    for (int e = 0; e < 12; ++e) {
      const int axis = e / 4, b = (axis + 1) % 3, c = (axis + 2) % 3;
      Eigen::Vector3d from = box.min(), to;
      if (e & 1) from[b] = box.max()[b];
      if (e & 2) from[c] = box.max()[c];
      to = from;
      to[axis] = box.max()[axis];
      over.line(from, to, "box");
    }
    const char* kAxes[] = {"ax", "ay", "az"};
    const char* kNames[] = {"x", "y", "z"};
    for (int a = 0; a < 3; ++a)
      over.arrow(box.min(), box.min() + 0.22 * size * Eigen::Vector3d::Unit(a), kAxes[a], kNames[a]);
    // Beside the thing: at the corner of the box across from the axes, and in front of its foot.
    const Eigen::Vector3d across = box.max() - up * up.dot(box.max() - middle),
                          foot = middle - up * 0.5 * up.cwiseAbs().dot(box.sizes());
    over.arrow(across, across + up * 0.25 * size, "up", "up");
    if (!views_.views.empty()) {
      Eigen::Vector3d front = -views_.views.front().camera.rotation().row(2).transpose();
      front = (front - up * up.dot(front)).normalized();
      const Eigen::Vector3d edge = foot + front * 0.5 * front.cwiseAbs().dot(box.sizes());
      if (front.allFinite()) over.arrow(edge, edge + front * 0.14 * size, "front", "front");
    }
    for (size_t k = 0; k < run_.plan->actions.size(); ++k) {
      const PlanAction& action = run_.plan->actions[k];
      if (!(action.direction.norm() > 0)) continue;
      const Eigen::AlignedBox3d target = box_of(action.source.empty() ? action.target : action.source);
      const double half = 0.5 * action.direction.cwiseAbs().dot(target.sizes());
      const bool presses = action.type == ActionType::top_press || action.type == ActionType::side_compress;
      const Eigen::Vector3d start = target.center() + action.direction * (presses ? -half - 0.32 * size : half * 0.2);
      over.arrow(start, start + action.direction * (presses ? 0.3 : std::max(0.3, half / size + 0.15)) * size, "act",
                 std::to_string(k + 1));
    }
    return over.svg();
  }

  std::string view_section() {
    std::string html;
    for (const ViewPicture& picture : load_view_pictures(views_)) {
      const Camera& camera = std::find_if(views_.views.begin(), views_.views.end(), [&](const SceneView& v) {
                               return v.name == picture.view;
                             })->camera;
      const auto small = [](const Image& image) {
        return image.width <= kWidth ? image
                                     : fit_into(image, kWidth, std::max(1, image.height * kWidth / image.width));
      };
      pictures_.push_back(small(picture.rgb));
      captions_.push_back(picture.view);
      std::string labels;
      if (run_.state) {
        const Image painted =
            small(lift::label_picture(gaussians_, run_.state->gaussian_row, run_.inventory->residual_rows(), camera));
        labels = fmt::format("<img class=\"labels\" alt=\"Parts of the view {} in colours\" src=\"{}\">",
                             escaped(picture.view), data_address("image/jpeg", encode_jpeg(painted, 86)));
        painted_.push_back(painted);
      }
      html += fmt::format(
          "<figure class=\"view\" data-view=\"{}\"><div class=\"stack\"><img class=\"seen\" alt=\"The view {}\" "
          "width=\"{}\" height=\"{}\" src=\"{}\">{}"
          "<svg class=\"over\" viewBox=\"0 0 {} {}\" aria-hidden=\"true\"><g class=\"drawn\">{}</g><g "
          "class=\"marks\"></g></svg></div><figcaption>{}</figcaption></figure>\n",
          escaped(picture.view), escaped(picture.view), pictures_.back().width, pictures_.back().height,
          data_address("image/jpeg", encode_jpeg(pictures_.back(), 86)), labels, camera.width, camera.height,
          overlay(camera), escaped(picture.view));
    }
    for (size_t k = 0; k < painted_.size(); ++k) {
      pictures_.push_back(painted_[k]);
      captions_.push_back(captions_[k] + ", parts");
    }
    std::string legend;
    for (size_t r = 0; r < run_.inventory->rows.size(); ++r) {
      const InventoryRow& row = run_.inventory->rows[r];
      const std::array<float, 3> c = splat::row_color(static_cast<int32_t>(r), row.residual);
      legend += fmt::format(
          "<span><svg class=\"swatch\" viewBox=\"0 0 10 10\" aria-hidden=\"true\"><circle cx=\"5\" cy=\"5\" r=\"5\" "
          "fill=\"rgb({:.0f},{:.0f},{:.0f})\"/></svg>{}</span>",
          255 * c[0], 255 * c[1], 255 * c[2], escaped(row.name.empty() ? row.part : row.name));
    }
    return "<section id=\"views\"><h2>Is it the right way up, and which part is which?</h2>\n<p class=\"switch\" "
           "role=\"group\" aria-label=\"What the views show\">"
           "<button type=\"button\" data-show=\"seen\" aria-pressed=\"true\">As it is</button><button type=\"button\" "
           "data-show=\"labels\" aria-pressed=\"false\">Parts</button>"
           "<button type=\"button\" data-show=\"plain\" aria-pressed=\"false\">Without lines</button></p>\n<div "
           "class=\"views\">" +
           html + "</div>\n<p class=\"legend\">" + legend + "</p></section>\n";
  }

  std::string plan_section() const {
    std::string html;
    for (const PlanAction& action : run_.plan->actions) html += "<li>" + action_words(action, run_) + "</li>\n";
    html = html.empty() ? "<p>No action: things move by gravity alone.</p>\n" : "<ol>" + html + "</ol>\n";
    std::string notes;
    for (const std::string& correction : run_.plan->corrections) notes += "<li>" + escaped(correction) + "</li>";
    if (!notes.empty()) html += "<h3>Assumed, or not understood</h3><ul>" + notes + "</ul>\n";
    if (!run_.plan->actions.empty())
      html +=
          "<details class=\"edit\"><summary>Change direction, strength and time</summary>\n<div "
          "id=\"action-editor\" class=\"editor\"></div></details>\n";
    return "<section id=\"plan\"><h2>What will happen</h2>\n" + html + "</section>\n";
  }

  // The coarse motion as a video of its own beside the page, in the page, and four of its pictures.
  std::string motion_section() {
    const PreviewMotion motion = preview_motion(run_, scene_, gaussians_);
    const std::string path = fs::path(options_.out).replace_extension(".mp4").string();
    if (motion.pictures.empty()) {
      std::error_code ignored;
      fs::remove(path, ignored);
      omitted_.push_back({"coarse motion", motion.why_not});
      return "<section id=\"motion\"><h2>How it will move, roughly</h2>\n<p class=\"quiet\">Not shown: " +
             escaped(motion.why_not) + ".</p></section>\n";
    }
    const size_t last = motion.pictures.size() - 1;
    const Image& first = motion.pictures.front();
    splat::VideoWriter video(path, first.width, first.height,
                             std::clamp(static_cast<double>(last) / motion.times.back(), 0.01, 1000.0));
    for (const Image& picture : motion.pictures) video.write(picture);
    video.finish();
    video_ = path;
    std::string strip;
    for (size_t k = 0; k < kStrip; ++k) {
      const size_t t = k * last / (kStrip - 1);
      const std::string time = fmt::format("{:.2f} s", motion.times[t]);
      strip += fmt::format(
          "<figure><img alt=\"At {}\" width=\"{}\" height=\"{}\" src=\"{}\"><figcaption>{}</figcaption></figure>", time,
          first.width, first.height, data_address("image/jpeg", encode_jpeg(motion.pictures[t], 80)), time);
      pictures_.push_back(fit_into(motion.pictures[t], pictures_.front().width, pictures_.front().height));
      captions_.push_back("roughly, " + time);
    }
    return fmt::format(
        "<section id=\"motion\"><h2>How it will move, roughly</h2>\n<div class=\"motion\"><video controls loop muted "
        "playsinline preload=\"metadata\" width=\"{}\" height=\"{}\" aria-label=\"The coarse motion\" poster=\"{}\" "
        "src=\"{}\"></video>\n<div class=\"strip\">{}</div></div>\n<p class=\"quiet\">{}</p></section>\n",
        first.width, first.height, data_address("image/jpeg", encode_jpeg(first, 80)),
        data_address("video/mp4", read_file(path)), strip, escaped(motion.about));
  }

  static std::string mark_section() {
    return "<section id=\"mark\"><h2>Say which part is which</h2>\n<p>Choose a part or name a new one, then click "
           "around it in each view, or draw around it. A click on the first point, Enter or a double click closes the "
           "outline; "
           "Backspace takes the last point away.</p>\n<div id=\"editor\" class=\"editor\"></div>\n<noscript><p>Marking "
           "needs "
           "JavaScript.</p></noscript></section>\n";
  }

  static std::string material_section() {
    return "<section id=\"materials\"><h2>Say what the parts are made of</h2>\n<p>What is stated here holds in every "
           "candidate. An empty field stays as it is assumed, or as the label has it.</p>\n<div "
           "id=\"material-editor\" class=\"editor\"></div></section>\n";
  }

  // What each part is assumed to be: as the first candidate has it, else as the evidence says.
  Json assumed_materials() const {
    Json materials = Json::object();
    if (!run_.evidence) return materials;
    for (size_t r = 0; r < run_.inventory->rows.size(); ++r) {
      const EvidenceRow& row = run_.evidence->rows.at(r);
      const LabelPrior& label = kLabels[static_cast<size_t>(row.label)];
      materials[row.key] = {
          {"label", label.name}, {"E", std::pow(10, row.log10_E)}, {"nu", row.nu}, {"rho", label.rho}};
    }
    for (const RunRecords::Attempt& attempt : run_.attempts) {
      if (attempt.candidate.order != 0) continue;
      for (const CandidateRow& row : attempt.candidate.rows)
        materials[row.key] = {
            {"label", kLabels[static_cast<size_t>(row.label)].name}, {"E", row.E}, {"nu", row.nu}, {"rho", row.rho}};
    }
    return materials;
  }

  // Inventory and plan as a person would author them, what is assumed, and the labels that there are.
  std::string data() const {
    Json inventory = load_record(run_.path("inventory.json"), "inventory");
    for (const char* own : {"provenance", "exchanges", "omitted"}) inventory.erase(own);
    Json plan = load_record(run_.path("plan.json"), "plan");
    for (const char* own : {"provenance", "omitted"}) plan.erase(own);
    Json labels = Json::array(), colors = Json::array(), actions = Json::array();
    for (const LabelPrior& label : kLabels)
      labels.push_back(
          {{"name", label.name}, {"E", label.E_default()}, {"nu", label.nu_default()}, {"rho", label.rho}});
    for (size_t r = 0; r < 9; ++r) {
      const std::array<float, 3> c = splat::row_color(static_cast<int32_t>(r), false);
      colors.push_back({c[0], c[1], c[2]});
    }
    for (const PlanAction& action : run_.plan->actions) {
      const ActionLine& line = action_line(action.type);
      std::string words = action_name(action.type);
      std::replace(words.begin(), words.end(), '_', ' ');
      actions.push_back({{"words", words + " of " + name_of(*run_.inventory, action.target)},
                         {"unit", line.unit},
                         {"most", line.max},
                         {"has_strength", line.max > 0}});
    }
    return "<script type=\"application/json\" id=\"data\">" +
           script_json({{"inventory", inventory},
                        {"plan", plan},
                        {"actions", actions},
                        {"materials", assumed_materials()},
                        {"labels", labels},
                        {"colors", colors}}) +
           "</script>\n";
  }

  PreviewOptions options_;
  RunRecords run_;
  Scene scene_, views_;
  Gaussians gaussians_;
  std::vector<Image> pictures_, painted_;
  std::vector<std::string> captions_;
  std::string video_;  // of the coarse motion; empty: none
  std::vector<Omission> omitted_;
};

}  // namespace

void write_preview(const PreviewOptions& options) {
  Preview(options).write();
}

}  // namespace physmas::report
