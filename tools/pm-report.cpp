// pm-report: the page of a run, and a page of many runs.
#include "base/command_line.h"
#include "base/error.h"
#include "base/file.h"
#include "report/preview.h"
#include "report/run_report.h"
#include "report/serve.h"

using namespace physmas;

int main(int argc, char** argv) {
  report::ReportOptions options;
  std::vector<std::string> runs;
  std::string index_out;
  double viewer = 3, videos = 3;
  report::PreviewOptions preview_options;
  report::ServeOptions serving;
  Command index, preview, served;
  const auto is_html = [](const std::string& path) {
    return path.size() > 5 && path.substr(path.size() - 5) == ".html" ? std::string()
                                                                      : "expected a name that ends in .html";
  };
  ToolMain tool;
  tool.name = "pm-report";
  tool.description = "Writes the page of a run: its video, what was tried, why, and how to do it again; one file.";
  tool.footer =
      "Example: pm-report --run runs/demo --out runs/demo/report.html\n"
      "         pm-report preview --run runs/demo\n"
      "         pm-report serve --run runs/demo\n"
      "         pm-report index runs/batch/cake runs/batch/lamp --out runs/batch/index.html\n"
      "Reads the records in a run's folder (physmas/scene, inventory, plan, state, evidence, round, candidate, "
      "execution, render, screen,\n"
      "cameras, rollout) and its videos; writes the page and physmas/report/1 beside it.";
  tool.options = [&](Command app) {
    app.add_option("--run", options.run, "Folder of a run, finished or not (required)").type_name("DIR");
    app.add_option("--out", options.out, "Page to write, .html; report.html in the run's folder when absent")
        .check(is_html)
        .type_name("FILE");
    app.add_option(
           "--failed", options.failed,
           "A stage of the run that has just failed, as make calls it: the page says what it said and what to do")
        .type_name("STAGE");
    app.add_option("--status", options.status, "Exit status of the command of that stage")
        .between(0, 255)
        .capture_default_str();
    app.add_option("--viewer", viewer, "Megabytes that the 3D viewer's stream may take; 0: no viewer")
        .between(0.0, 500.0)
        .capture_default_str();
    app.add_option("--videos", videos,
                   "Megabytes that the candidates' videos may take together; others are played from the run's folder")
        .between(0.0, 500.0)
        .capture_default_str();
    preview =
        app.add_subcommand("preview", "The page before the candidates: views, parts, plan, and a way to mark parts");
    preview.add_option("--run", preview_options.run, "Folder of a run that was grounded").type_name("DIR").required();
    preview
        .add_option("--out", preview_options.out, "Page to write, .html; preview.html in the run's folder when absent")
        .check(is_html)
        .type_name("FILE");
    served = app.add_subcommand(
        "serve", "A run's pages on this machine alone; what is marked on the preview is written into the run's folder");
    served.add_option("--run", serving.run, "Folder of a run with preview.html or report.html")
        .type_name("DIR")
        .required();
    served.add_option("--port", serving.port, "Port of 127.0.0.1; 0: any that is free")
        .between(0, 65535)
        .capture_default_str();
    served.add_option("--requests", serving.requests, "End after so many requests; 0: never")
        .not_negative()
        .capture_default_str();
    index = app.add_subcommand("index", "A page with a row per run");
    index.add_option("RUN", runs, "Folders of runs").required();
    index.add_option("--out", index_out, "Page to write, .html").required().check(is_html);
  };
  tool.work = [&](const CommonOptions&) {
    if (index.parsed()) {
      report::write_run_index(runs, index_out);
      return static_cast<int>(ExitCode::done);
    }
    if (served.parsed()) {
      report::serve(serving);
      return static_cast<int>(ExitCode::done);
    }
    if (preview.parsed()) {
      if (preview_options.out.empty()) preview_options.out = join_path(preview_options.run, "preview.html");
      report::write_preview(preview_options);
      return static_cast<int>(ExitCode::done);
    }
    if (options.run.empty()) throw Error(ExitCode::usage, "--run is required; see pm-report --help");
    if (options.out.empty()) options.out = join_path(options.run, "report.html");
    options.viewer_bytes = static_cast<size_t>(viewer * 1e6);
    options.candidate_bytes = static_cast<size_t>(videos * 1e6);
    report::write_run_report(options);
    return static_cast<int>(ExitCode::done);
  };
  return run_tool(argc, argv, tool);
}
