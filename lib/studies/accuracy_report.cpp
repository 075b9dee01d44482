#include "studies/accuracy_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <thread>

#include "base/file.h"
#include "records/json.h"
#include "studies/gnuplot.h"

namespace physmas::studies {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

const char* precision_name(const AccuracySetting& s) {
  return s.precision == mpm::Precision::full ? "double" : "float";
}

Json study_json(const AccuracyStudy& study) {
  Json json;
  json["name"] = study.setup.name;
  json["text"] = study.setup.text;
  json["particles"] = study.setup.problem.particles.size();
  json["size"] = study.setup.size;
  json["duration"] = study.setup.duration;
  json["reference"] = {{"particles", study.reference.particles}, {"steps", study.reference.steps}};
  for (int m = 0; m < kAccuracyMetrics; ++m) {
    const double error = study.reference.doubled_step[m];
    json["reference"]["doubled_step"][kAccuracyMetricNames[m]] = error >= 0 ? Json(error) : Json();
  }
  json["results"] = Json::array();
  for (const AccuracyResult& r : study.results) {
    Json entry;
    entry["id"] = r.setting.id();
    entry["n"] = r.setting.n;
    entry["step"] = r.setting.step.name;
    entry["precision"] = precision_name(r.setting);
    entry["threads"] = r.setting.device.threads;
    entry["status"] = r.stable ? "stable" : "diverged";
    entry["reason"] = r.reason;
    entry["steps"] = r.steps;
    for (int m = 0; m < kAccuracyMetrics; ++m)
      entry["errors"][kAccuracyMetricNames[m]] = r.error[m] >= 0 ? Json(r.error[m]) : Json();
    json["results"].push_back(entry);
  }
  return json;
}

Json runtime_json(const std::vector<AccuracyStudy>& studies, const std::string& command) {
  Json json;
  json["processor"] = processor_name();
  json["cores"] = std::thread::hardware_concurrency();
  json["command"] = command;
  for (const AccuracyStudy& study : studies) {
    Json& entry = json["cases"][study.setup.name];
    entry["reference"] = {{"seconds", study.reference.seconds}};
    for (const AccuracyResult& r : study.results) {
      Json optimal = Json::array();
      for (int m = 0; m < kAccuracyMetrics; ++m) {
        if (r.pareto[m]) optimal.push_back(kAccuracyMetricNames[m]);
      }
      entry[r.setting.id()] = {{"seconds", r.seconds}, {"median", r.median_seconds}, {"pareto", optimal}};
    }
  }
  return json;
}

std::string csv(const std::vector<AccuracyStudy>& studies) {
  std::string text = "case,n,step,precision,threads,status,steps,seconds";
  for (const char* name : kAccuracyMetricNames) text += fmt::format(",{0},{0}_pareto", name);
  text += "\n";
  for (const AccuracyStudy& study : studies) {
    for (const AccuracyResult& r : study.results) {
      text += fmt::format("{},{},{},{},{},{},{},{:.6g}", study.setup.name, r.setting.n, r.setting.step.name,
                          precision_name(r.setting), r.setting.device.threads, r.stable ? "stable" : "diverged",
                          r.steps, r.median_seconds);
      for (int m = 0; m < kAccuracyMetrics; ++m)
        text += r.error[m] >= 0 ? fmt::format(",{:.6g},{}", r.error[m], r.pareto[m] ? 1 : 0) : ",,";
      text += "\n";
    }
  }
  return text;
}

// One figure per metric with a panel per case: a point per setting, coloured by grid, shaped by what is special about
// it, and a line through the Pareto-optimal ones.
std::string figure(const std::vector<AccuracyStudy>& studies, int metric) {
  std::string text = fmt::format(
      "reset\nset terminal pngcairo size 1080,640 font 'sans,9'\nset output 'accuracy-{}.png'\n"
      "set multiplot layout 2,3 title '{}'\nset logscale xy\nset format y '%.0e'\nset format x '%g'\n"
      "set xlabel 'run time [s]'\nset key off\nset grid lc rgb '#dddddd'\n",
      kAccuracyMetricNames[metric], kAccuracyMetricTexts[metric]);
  static const char* const kColours[] = {"#8a5aa8", "#3574b5", "#2a9d6a", "#d9822b", "#c0392b", "#555555"};
  std::set<int> grids;
  for (const AccuracyStudy& study : studies) {
    for (const AccuracyResult& r : study.results) grids.insert(r.setting.n);
  }
  const auto shape = [](const AccuracySetting& s) {
    return s.step.name == "paper" ? 9 : s.step.name == "cfl" ? 5 : s.precision == mpm::Precision::full ? 13 : 7;
  };
  const std::pair<int, const char*> shapes[] = {
      {7, "float, fixed dt"}, {9, "float, paper rule"}, {5, "float, cfl rule"}, {13, "double, dt = 2e-4"}};
  for (const AccuracyStudy& study : studies) {
    std::string data, plots;
    int block = 0;
    const auto add_block = [&](const std::string& points, const std::string& style) {
      if (points.empty()) return;
      data += fmt::format("$d{} << EOD\n{}EOD\n", block, points);
      plots += fmt::format("{} $d{} using 1:2 {}", plots.empty() ? "plot" : ",", block++, style);
    };
    int colour = 0;
    for (const int n : grids) {
      for (const auto& [kind, name] : shapes) {
        std::string points;
        for (const AccuracyResult& r : study.results) {
          if (r.setting.n == n && shape(r.setting) == kind && r.error[metric] > 0)
            points += fmt::format("{:.6g} {:.6g}\n", r.median_seconds, r.error[metric]);
        }
        add_block(points, fmt::format("with points pt {} ps 1.1 lc rgb '{}'", kind, kColours[colour % 6]));
      }
      ++colour;
    }
    std::vector<std::pair<double, double>> best;
    for (const AccuracyResult& r : study.results) {
      if (r.pareto[metric] && r.error[metric] > 0) best.emplace_back(r.median_seconds, r.error[metric]);
    }
    std::sort(best.begin(), best.end());
    std::string line;
    for (const auto& [seconds, error] : best) line += fmt::format("{:.6g} {:.6g}\n", seconds, error);
    add_block(line, "with linespoints pt 6 ps 2 lc rgb 'black' lw 1");
    if (study.reference.doubled_step[metric] > 0 && !plots.empty())
      plots += fmt::format(", {:.6g} with lines lc rgb '#888888' dt 2", study.reference.doubled_step[metric]);
    if (!plots.empty()) text += data + fmt::format("set title '{}'\n", study.setup.name) + plots + "\n";
  }
  // The last panel is the legend.
  text +=
      "unset logscale\nset title ''\nunset xlabel\nunset tics\nunset border\nunset grid\nset key at graph 0.9,0.95 "
      "right\n"
      "set xrange [0:1]\nset yrange [0:1]\nplot ";
  int colour = 0;
  for (const int n : grids)
    text += fmt::format("2 with points pt 7 ps 1.1 lc rgb '{}' title 'grid {}', ", kColours[colour++ % 6], n);
  for (const auto& [kind, name] : shapes)
    text += fmt::format("2 with points pt {} ps 1.1 lc rgb 'black' title '{}', ", kind, name);
  return text +
         "2 with linespoints pt 6 ps 2 lc rgb 'black' title 'Pareto-optimal', "
         "2 with lines lc rgb '#888888' dt 2 title 'the reference with twice its step'\nunset multiplot\n";
}

}  // namespace

void write_accuracy(const std::string& folder, const std::vector<AccuracyStudy>& studies, const AccuracyPlan& plan,
                    const std::string& command, const Provenance& provenance) {
  Json json;
  for (int m = 0; m < kAccuracyMetrics; ++m) json["metrics"][kAccuracyMetricNames[m]] = kAccuracyMetricTexts[m];
  json["repeats"] = plan.repeats;
  json["reference"] = {{"n", plan.reference_n}, {"dt", plan.reference_dt}, {"precision", "double"}};
  json["cases"] = Json::array();
  for (const AccuracyStudy& study : studies) json["cases"].push_back(study_json(study));
  json["runtime"] = runtime_json(studies, command);
  save_record(folder + "/accuracy.json", "accuracy", provenance, json);
  write_file(folder + "/accuracy.csv", csv(studies));
  std::string script;
  for (int m = 0; m < kAccuracyMetrics; ++m) script += figure(studies, m);
  run_gnuplot(folder, "accuracy.gp", script);
}

std::string accuracy_table(const std::vector<AccuracyStudy>& studies) {
  std::string text = fmt::format("{:<18} {:<22} {:>9} {:>9} {:>10} {:>10} {:>10} {:>10}\n", "case", "setting",
                                 "seconds", "position", "trajectory", "area", "strain", "energy");
  for (const AccuracyStudy& study : studies) {
    std::vector<const AccuracyResult*> best;
    for (const AccuracyResult& r : study.results) {
      if (r.pareto[0]) best.push_back(&r);
    }
    std::sort(best.begin(), best.end(),
              [](const AccuracyResult* a, const AccuracyResult* b) { return a->median_seconds < b->median_seconds; });
    for (const AccuracyResult* r : best) {
      text += fmt::format("{:<18} {:<22} {:>9.4f} {:>9.5f} {:>10.4f} {:>10.4f} {:>10.4f} {:>10.5f}\n", study.setup.name,
                          r->setting.id(), r->median_seconds, r->error[0], r->error[1], r->error[2], r->error[3],
                          r->error[4]);
    }
  }
  return text;
}

}  // namespace physmas::studies
