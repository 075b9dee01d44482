#include "report/viewer.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/log.h"
#include "records/script_json.h"
#include "remote/base64.h"
#include "report/page.h"
#include "scene/gaussian_files.h"
#include "splat/floor_shadow.h"
#include "splat/middle_box.h"
#include "splat/renderer.h"
#include "splat/row_colors.h"
#include "splat/video_cameras.h"

namespace physmas::report {
namespace {

Json camera_json(const Camera& camera) {
  const Eigen::Matrix3d R = camera.rotation();
  Json rotation = Json::array();
  for (int i = 0; i < 9; ++i) rotation.push_back(R(i / 3, i % 3));
  return {{"width", camera.width}, {"height", camera.height},
          {"fx", camera.fx},       {"fy", camera.fy},
          {"cx", camera.cx},       {"cy", camera.cy},
          {"rotation", rotation},  {"translation", to_json(Eigen::Vector3d(camera.translation()))}};
}

// Shear modulus of each row, Pa; zero without a candidate.
std::vector<double> moduli(const Candidate* candidate, size_t rows) {
  std::vector<double> mu(rows, 0);
  if (candidate == nullptr) return mu;
  for (const CandidateRow& row : candidate->rows) {
    // What a strain of the deviator's Frobenius norm gives as von Mises stress in small deformations.
    if (row.row >= 0 && static_cast<size_t>(row.row) < rows)
      mu[static_cast<size_t>(row.row)] = std::sqrt(6.0) * row.E / (2 * (1 + row.nu));
  }
  return mu;
}

Json rows_json(const ViewerSource& source, const Stream& stream) {
  std::vector<long> counts(source.state.row_keys.size(), 0);
  for (const size_t i : stream.kept) ++counts[static_cast<size_t>(source.state.gaussian_row[i])];
  const std::vector<double> mu = moduli(source.candidate, counts.size());
  Json rows = Json::array();
  for (size_t r = 0; r < counts.size(); ++r) {
    const InventoryRow* row = source.inventory != nullptr ? &source.inventory->rows.at(r) : nullptr;
    const std::string& key = source.state.row_keys[r];
    const std::array<float, 3> color = splat::row_color(static_cast<int32_t>(r), row != nullptr && row->residual);
    rows.push_back({{"key", key},
                    {"name", row != nullptr && !row->name.empty() ? row->name : key},
                    {"color", {color[0], color[1], color[2]}},
                    {"count", counts[r]},
                    {"modulus", mu[r]}});
  }
  return rows;
}

std::string about_text(const ViewerSource& source, const Stream& s) {
  const auto all = source.gaussians.size();
  std::string text = fmt::format("{}, {}: ", source.scene.name, source.name);
  text += s.kept.size() == all ? fmt::format("{} Gaussians", all)
                               : fmt::format("the {} of {} Gaussians that cover most", s.kept.size(), all);
  text += static_cast<int>(s.frames.size()) == source.rollout.count()
              ? fmt::format(", {} frames", s.frames.size())
              : fmt::format(", {} of {} frames, with what lies between drawn in between", s.frames.size(),
                            source.rollout.count());
  text += fmt::format(". Means are off by at most {:.2g} scene units, entries of F by {:.2g}.",
                      s.steps.position / 2 + s.steps.rest / 2, s.steps.deformation / 2);
  if (s.hidden > 0) text += fmt::format(" {} Gaussians over all frames were not finite and are not shown.", s.hidden);
  if (s.cut > 0) text += fmt::format(" {} values were too large and are cut.", s.cut);
  return text;
}

}  // namespace

Viewer make_viewer(const ViewerSource& source, const StreamLimits& limits) {
  Stream stream = make_stream(
      source.gaussians, source.state.gaussian_row, source.scene.run.render.sh_degree, source.rollout.count(),
      [&](int t) { return source.rollout.frame(t); }, limits);
  const RunSpecification& run = source.scene.run;
  const Eigen::AlignedBox3d box = splat::middle_box(source.gaussians);
  const Eigen::Vector3d up = run.placement.up_vector();
  const splat::FloorPlane floor = splat::floor_plane(run, source.state.map, source.gaussians);
  const Camera& first = source.cameras.camera(0);
  Eigen::Vector3d front = first.rotation().row(2).transpose();
  front -= up * up.dot(front);
  if (front.norm() < 1e-6) front = up.unitOrthogonal();
  const splat::Renderer renderer(source.gaussians);
  Viewer viewer;
  viewer.about = about_text(source, stream);
  Json times = Json::array(), cameras = Json::array();
  for (const int t : stream.frames) times.push_back(source.rollout.time(t));
  for (const Camera& camera : source.cameras.cameras) cameras.push_back(camera_json(camera));
  const StreamSteps& s = stream.steps;
  viewer.header = {
      {"about", viewer.about},
      {"gaussians", stream.kept.size()},
      {"frames", stream.frames},
      {"times", times},
      {"sh_degree", stream.sh_degree},
      {"chunks", stream.chunk_bytes},
      {"steps",
       {{"position", s.position},
        {"deformation", s.deformation},
        {"rest", s.rest},
        {"log_scale", s.log_scale},
        {"rotation", s.rotation},
        {"opacity", s.opacity},
        {"color", s.color},
        {"harmonics", s.harmonics}}},
      {"origin", to_json(stream.origin)},
      {"middle", to_json(Eigen::Vector3d(box.center()))},
      {"size", std::max(box.sizes().norm(), 1e-9)},
      {"near", renderer.default_near()},
      {"background", to_json(run.render.background)},
      {"up", to_json(up)},
      {"front", to_json(Eigen::Vector3d(front.normalized()))},
      {"floor",
       {{"point", to_json(floor.point)}, {"normal", to_json(floor.normal)}, {"shown", run.render.has_floor()}}},
      {"cameras", cameras},
      {"rows", rows_json(source, stream)}};
  viewer.bytes = std::move(stream.bytes);
  return viewer;
}

void write_viewer_page(const ViewerFiles& files) {
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(files.scene, needs);
  Inventory inventory;
  if (!files.inventory.empty()) inventory = load_inventory(files.inventory);
  const State state = load_state(files.state, files.inventory.empty() ? nullptr : &inventory);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, files.state);
  const ExecutionRecord execution = load_execution_of(files.rollout);
  const splat::RolloutFrames rollout(files.rollout, state);
  const FittedCameras cameras = splat::video_cameras(scene, state, gaussians, rollout, execution, files.cameras);
  Candidate candidate;
  if (!files.candidate.empty()) candidate = load_candidate(files.candidate);
  const Viewer viewer =
      make_viewer({scene, state, gaussians, rollout, cameras, files.inventory.empty() ? nullptr : &inventory,
                   files.candidate.empty() ? nullptr : &candidate, execution.candidate});
  Page page;
  page.title = scene.name + " - " + execution.candidate;
  page.styles = {"page.css", "viewer.css", "whole-viewer.css"};
  page.scripts = {"viewer.js", "whole-viewer.js"};
  page.body = "<main></main>\n<script type=\"application/json\" id=\"header\">" + script_json(viewer.header) +
              "</script>\n<script type=\"text/plain\" id=\"stream\">" + remote::base64_of(viewer.bytes) + "</script>\n";
  const std::string text = page_text(page);
  write_file(files.out, text);
  log_info(fmt::format("{}: {:.1f} MB. {}", files.out, static_cast<double>(text.size()) / 1e6, viewer.about));
}

}  // namespace physmas::report
