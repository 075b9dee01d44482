// pm-eval error and error-study: the estimated discretisation error of a run, and whether it is the true one.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "base/output.h"
#include "bind/problem.h"
#include "bind/start.h"
#include "bind/timing.h"
#include "bind/vector.h"
#include "records/execution.h"
#include "records/json.h"
#include "records/rollout.h"
#include "records/scene.h"
#include "records/screen.h"
#include "studies/commands.h"
#include "studies/discretisation_error.h"
#include "studies/error_study.h"

namespace fs = std::filesystem;

namespace physmas::studies {
namespace {

struct ErrorOptions {
  std::string scene, view, state, candidate, rollout, accepted, out;
};

constexpr int kFewestCells = 32;     // a quarter of them is the coarsest grid there is
constexpr int kMostPixels = 200;     // of the picture that the image metrics are measured in, along its longer edge
constexpr size_t kMostDrawn = 8000;  // points in it

// A run that is to be measured.
struct MeasuredRun {
  explicit MeasuredRun(const ErrorOptions& options)
      : scene(load_scene(options.scene, {})),
        state(load_state(options.state)),
        candidate(load_candidate(options.candidate)),
        execution(load_execution_of(options.rollout)) {
    require_made_from(execution_path_of(options.rollout), options.state, false);
    require_made_from(execution_path_of(options.rollout), options.candidate, false);
    if (execution.diverged) {
      throw invalid_input({execution_path_of(options.rollout), "/numerical/status", "diverged", "stable",
                           "what has diverged has no error that could be estimated"});
    }
    scene.run.grid.n = execution.grid.value("n", scene.run.grid.n);
    scene.run.time.frames = execution.frames;
    if (scene.run.grid.n < kFewestCells)
      throw invalid_input({options.scene, "/run/grid/n", std::to_string(scene.run.grid.n),
                           fmt::format("at least {}, so that a quarter is a grid", kFewestCells), "--set grid.n"});
    problem = bind::bind_problem(candidate, state, scene.run, {options.state, options.candidate});
    const RolloutReader reader(options.rollout, state.carrier_count());
    const size_t points = state.carrier_count();
    for (int t = 0; t < reader.frame_count(); ++t) {
      const std::vector<float> position = reader.frame(t).position;
      std::vector<mpm::Vec3d> x(points);
      for (size_t i = 0; i < points; ++i) x[i] = {position[3 * i], position[3 * i + 1], position[3 * i + 2]};
      paths.push_back(std::move(x));
    }
    row_of.assign(problem.particles.row.begin(), problem.particles.row.begin() + static_cast<long>(points));
  }

  // The companions' largest step is `factor` times that of the run, so that all lie on one path to the limit.
  mpm::Timing timing(int factor) const {
    mpm::Timing timing;
    timing.frames = execution.frames;
    timing.frame_dt = scene.run.time.frame_dt;
    timing.rule = mpm::StepRule::cfl;
    const double step = factor * (execution.step_rule == "cfl" ? scene.run.time.substep_dt : execution.dt);
    timing.substeps = bind::whole_substeps(step, timing.frame_dt);
    return timing;
  }

  Scene scene;
  State state;
  Candidate candidate;
  ExecutionRecord execution;
  mpm::Problem problem;
  PointPaths paths;         // of the Gaussians that are particles
  std::vector<int> row_of;  // of those
};

PointPaths accompany(const MeasuredRun& run, int factor, const Device& device, Json& record) {
  Companion companion = make_companion(run.problem, factor);
  bind::bind_start(run.scene.run.time, device, companion.problem);
  mpm::Result result;
  PointPaths paths =
      run_companion(companion, run.problem.particles, run.row_of.size(), run.timing(factor), device, &result);
  record.push_back({{"n", companion.problem.domain.n},
                    {"particles", companion.problem.particles.size()},
                    {"substeps", result.steps},
                    {"dt", result.dt},
                    {"status", result.status == mpm::Status::stable ? "stable" : "diverged"}});
  if (result.status != mpm::Status::stable) paths.clear();
  return paths;
}

Json estimate_json(const std::string& name, const std::string& unit, const ErrorEstimate& e) {
  Json json = {{"name", name}, {"unit", unit}};
  if (!e.reason.empty()) {
    json["status"] = "invalid";
    json["reason"] = e.reason;
    return json;
  }
  json["status"] = "valid";
  json["estimate"] = e.estimate;
  json["bound"] = e.bound;
  json["difference"] = e.difference;
  json["coarse_difference"] = e.coarse_difference;
  json["order"] = e.order;
  json["order_range"] = {std::min(e.lowest_order, e.highest_order), std::max(e.lowest_order, e.highest_order)};
  json["regular"] = e.regular;
  return json;
}

// scale: what the numbers are multiplied by.
void print_estimate(const std::string& name, const ErrorEstimate& e, double scale, const std::string& unit) {
  if (!e.reason.empty()) {
    print("{:<28} none: {}\n", name, e.reason);
    return;
  }
  print("{:<28} {:8.3f} {} (not above {:.3f}; observed order {:.1f}{})\n", name, scale * e.estimate, unit,
        scale * e.bound, e.order, e.regular ? "" : ", not regular");
}

// The first output camera at the size that the metrics need, and the paths as it sees them.
ImageErrors image_errors(const MeasuredRun& run, const RefinedPaths& paths, const Camera& output,
                         const ErrorEstimate& position) {
  Camera camera = output;
  const double smaller = std::min(1.0, static_cast<double>(kMostPixels) / std::max(camera.width, camera.height));
  camera.width = static_cast<int>(std::ceil(camera.width * smaller));
  camera.height = static_cast<int>(std::ceil(camera.height * smaller));
  for (double* number : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *number *= smaller;
  const size_t points = run.row_of.size(), stride = (points + kMostDrawn - 1) / kMostDrawn;
  const auto seen = [&](const PointPaths& path) {
    PointPaths some;
    for (const std::vector<mpm::Vec3d>& x : path) {
      std::vector<mpm::Vec3d> y;
      for (size_t i = 0; i < points; i += stride) {
        const Eigen::Vector3d p = run.state.map.to_scene({x[i].x, x[i].y, x[i].z});
        y.push_back({p.x(), p.y(), p.z()});
      }
      some.push_back(std::move(y));
    }
    return some;
  };
  // Discs that cover surfaces: of the points' mean spacing, wider by the root of how many each stands for.
  double volume = 0;
  for (const double v : run.problem.particles.volume) volume += v;
  const double spacing = std::cbrt(volume / static_cast<double>(run.problem.particles.size())) / run.state.map.s;
  const double radius = 0.75 * spacing * std::sqrt(static_cast<double>(stride));
  return studies::image_errors({seen(paths.fine), seen(paths.half), seen(paths.quarter)}, camera, radius, position);
}

// Files beside accepted.json: those of the accepted candidate.
void take_accepted(ErrorOptions& options) {
  const std::string id = load_accepted(options.accepted).candidate;
  const fs::path run = fs::path(options.accepted).parent_path();
  options.candidate = (run / "candidates" / (id + ".json")).string();
  options.rollout = (run / "rollouts" / (id + ".h5")).string();
}

int estimate_error(ErrorOptions options, const Device& device) {
  if (!options.accepted.empty()) take_accepted(options);
  if (options.candidate.empty() || options.rollout.empty())
    throw Error(ExitCode::usage, "--candidate and --rollout are required, or --accepted instead of both");
  const Stopwatch watch;
  const MeasuredRun run(options);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "error"}};
  for (const std::string& input : {options.scene, options.view, options.state, options.candidate, options.rollout}) {
    if (!input.empty()) provenance.add_input(input);
  }
  Json companions = Json::array();
  RefinedPaths paths;
  paths.fine = run.paths;
  paths.half = accompany(run, 2, device, companions);
  paths.quarter = accompany(run, 4, device, companions);
  Json json = {{"candidate", run.candidate.id},
               {"n", run.scene.run.grid.n},
               {"rule", run.execution.step_rule},
               {"dt", run.execution.dt},
               {"companions", companions}};
  Json measures = Json::array(), rows = Json::array();
  const std::vector<double> orders = orders_of(run.problem);
  const double size = longest_edge(run.paths.front(), run.row_of, -1);
  ErrorEstimate position;
  ImageErrors image;
  if (paths.half.size() != run.paths.size() || paths.quarter.size() != run.paths.size()) {
    position.reason = "a companion diverged";
    image.trajectory = image.area = image.strain = position;
  } else {
    position = position_error(paths, run.row_of, -1, orders);
    const bool seen = !options.view.empty();
    if (seen) {
      SceneNeeds needs;
      needs.output_cameras = true;
      image = image_errors(run, paths, load_scene(options.view, needs).output_camera(0), position);
    } else {
      image.trajectory.reason = image.area.reason = image.strain.reason = "no camera: --view names a scene with one";
    }
  }
  measures.push_back(estimate_json("position", "m", position));
  const std::pair<const char*, const ErrorEstimate*> seen[] = {
      {"trajectory_nrmse", &image.trajectory}, {"area_log_rmse", &image.area}, {"strain_rmse", &image.strain}};
  for (const auto& [name, e] : seen) measures.push_back(estimate_json(name, "100 times the raw RMSE", *e));
  print_estimate("position", position, size > 0 ? 100 / size : 0, "% of the scene's longest edge");
  for (const auto& [name, e] : seen) print_estimate(name, *e, 1, "");
  for (size_t r = 0; position.reason.empty() && r < orders.size(); ++r) {
    const double edge = longest_edge(run.paths.front(), run.row_of, static_cast<int>(r));
    const ErrorEstimate e = position_error(paths, run.row_of, static_cast<int>(r), orders);
    if (!e.reason.empty()) continue;
    Json row = estimate_json(run.state.row_keys.at(r), "m", e);
    row["longest_edge"] = edge;
    row["assumed_order"] = orders[r];
    rows.push_back(row);
    if (edge > 0) print_estimate("  " + run.state.row_keys.at(r), e, 100 / edge, "% of its longest edge");
  }
  json["longest_edge"] = size;
  json["measures"] = measures;
  json["rows"] = rows;
  const double simulated =
      run.execution.runtime.contains("seconds") ? run.execution.runtime["seconds"].value("total", 0.0) : 0;
  json["runtime"] = {{"seconds", watch.seconds()}, {"seconds_of_the_run", simulated}};
  save_record(options.out, "error", provenance, json);
  if (simulated > 0)
    log_info(fmt::format("{:.1f} s, {:.0f} % of the simulation's", watch.seconds(), 100 * watch.seconds() / simulated));
  return 0;
}

struct StudyOptions {
  std::string out;
  bool quick = false;
};

int study(const StudyOptions& options, const Device& device) {
  ErrorStudyPlan plan;
  if (options.quick) plan.n = 32, plan.finer = 2, plan.dt = 4e-4;
  const std::vector<ErrorCase> cases = error_study_cases(1.0 / plan.n, options.quick);
  Progress progress("case", static_cast<long>(cases.size()));
  std::vector<ErrorStudyRow> rows;
  for (const ErrorCase& c : cases) {
    rows.push_back(study_error(c, plan, device));
    progress.update(static_cast<long>(rows.size()));
  }
  Json json;
  json["n"] = plan.n;
  json["reference_n"] = plan.finer * plan.n;
  json["cases"] = Json::array();
  for (const ErrorStudyRow& row : rows) {
    Json measures = Json::array();
    for (int m = 0; m < kErrorMetrics; ++m) {
      const ErrorEstimate& e = row.estimate[m];
      measures.push_back({{"name", kErrorMetricNames[m]},
                          {"truth", row.truth[m]},
                          {"estimate", e.estimate},
                          {"bound", e.bound},
                          {"order", e.order}});
    }
    json["cases"].push_back({{"name", row.name},
                             {"text", row.text},
                             {"held_out", row.held_out},
                             {"size", row.size},
                             {"measures", measures}});
  }
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "error-study"}, {"quick", options.quick ? "yes" : "no"}};
  save_record(options.out, "error_study", provenance, json);
  print("{}", error_study_table(rows));
  return 0;
}

}  // namespace

Subcommand add_error_study_command(Command app) {
  const auto options = std::make_shared<StudyOptions>();
  Command command = app.add_subcommand(
      "error-study", "Estimated against true discretisation errors, of fifteen cases with a fine reference");
  command.add_option("--out", options->out, "Record to write (JSON)").required();
  command.add_flag("--quick", options->quick, "Two cases on coarse grids: some seconds");
  return {command, [options](const CommonOptions& common) { return study(*options, common.device); }};
}

Subcommand add_error_command(Command app) {
  const auto options = std::make_shared<ErrorOptions>();
  Command command = app.add_subcommand(
      "error", "Discretisation error of a run, estimated from the same scene on half and on a quarter of the cells");
  command.add_option("--scene", options->scene, "Scene or its simulate slice").required().type_name("FILE");
  command.add_option("--view", options->view, "Scene or its render slice, for the metrics of the image plane")
      .type_name("FILE");
  command.add_option("--state", options->state, "Labels and particles").required().type_name("FILE");
  auto candidate =
      command.add_option("--candidate", options->candidate, "Candidate that was simulated").type_name("FILE");
  auto rollout =
      command.add_option("--rollout", options->rollout, "Its rollout, with the record beside it").type_name("FILE");
  command
      .add_option("--accepted", options->accepted,
                  "accepted.json of a run's folder: the accepted candidate, instead of --candidate and --rollout")
      .type_name("FILE")
      .excludes(candidate)
      .excludes(rollout);
  command.add_option("--out", options->out, "Record to write (JSON)").required().type_name("FILE");
  return {command, [options](const CommonOptions& common) { return estimate_error(*options, common.device); }};
}

}  // namespace physmas::studies
