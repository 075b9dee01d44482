#include "studies/stability_report.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/file.h"
#include "records/json.h"
#include "studies/gnuplot.h"

namespace physmas::studies {
namespace {

constexpr double kMapRho = 1000, kMapNu = 0.35;

std::string to_csv(const std::vector<StabilityRun>& runs) {
  std::string text =
      "study,name,rule,precision,branch,E,nu,rho,status,reason,first_bad_step,late,steps,dt,smallest_dt,largest_dt,"
      "retries,limit,min_J,max_J,surplus,apart,outside,garbage\n";
  for (const StabilityRun& r : runs) {
    text += fmt::format(
        "{},\"{}\",{},{},{},{:g},{:g},{:g},{},{},{},{},{},{:.4g},{:.4g},{:.4g},{},{:.4g},{:.4g},{:.4g},"
        "{:.3g},{:.3g},{},{}\n",
        r.study, r.name, r.rule, r.precision, r.branch, r.E, r.nu, r.rho, r.stable ? "stable" : "diverged", r.reason,
        r.first_bad_step, r.late, r.steps, r.dt, r.smallest_dt, r.largest_dt, r.retries, r.limit, r.min_J, r.max_J,
        r.surplus, r.apart, r.outside, r.garbage);
  }
  return text;
}

// Where along E the step by the paper's rule first exceeds a limit, as an index into swept_E() (fractions between).
double border(const PaperStep& paper_step, mpm::Material m, double dx, bool dense) {
  const double low = std::log10(swept_E().front()), high = std::log10(swept_E().back());
  constexpr int kSteps = 2000;
  for (int k = 0; k <= kSteps; ++k) {
    const double e = low + (high - low) * k / kSteps;
    m.E = std::pow(10.0, e);
    if (paper_step({m}) <= (dense ? dx / mpm::wave_speed(m) : stable_limit(m, dx))) continue;
    size_t i = 1;
    while (i + 1 < swept_E().size() && swept_E()[i] < m.E) ++i;
    const double a = std::log10(swept_E()[i - 1]), b = std::log10(swept_E()[i]);
    return static_cast<double>(i - 1) + (e - a) / (b - a);
  }
  return static_cast<double>(swept_E().size());
}

std::string tics(const char* axis, const std::vector<double>& values) {
  std::string list;
  for (size_t i = 0; i < values.size(); ++i) list += fmt::format("{}'{:g}' {}", i ? ", " : "", values[i], i);
  return fmt::format("set {}tics ({})\n", axis, list);
}

// One axis of a map besides E.
struct MapAxis {
  const char* name;
  const char* label;
  const std::vector<double>& values;
  bool is_nu;
};

// Six panels: a cell per E (across) and nu or rho (up).
std::string map_script(const std::vector<StabilityRun>& runs, const PaperStep& paper_step, const MapAxis& axis,
                       bool cfl, double dx) {
  std::string script = fmt::format(
      "set terminal pngcairo size 1080,560 font 'sans,9'\nset output 'stability-{}-{}.png'\n"
      "set multiplot layout 2,3 title '{}'\nset xlabel 'E [Pa]'\nset ylabel '{}' offset 1\nset tics out nomirror\n"
      "set xrange [-0.5:{}]\nset yrange [-0.5:{}]\nset xtics rotate by 45 right\n{}{}unset key\n",
      cfl ? "cfl" : "paper", axis.name,
      cfl ? "--timestep cfl: substeps per frame of 0.04 s, log10; white: not stable"
          : "--timestep paper: green stable; diverged: orange energy, red speed, violet step. Step = limit of a lone "
            "particle "
            "(solid), of packed material dx/c (dashed)",
      axis.label, static_cast<double>(swept_E().size()) - 0.5, static_cast<double>(axis.values.size()) - 0.5,
      tics("x", swept_E()), tics("y", axis.values));
  script += cfl ? "set palette defined (0 '#f7fbff', 1 '#6baed6', 2 '#08306b')\nset cbrange [2:8]\n"
                : "set palette maxcolors 4 defined (0 '#7fbf7b', 1 '#fdae61', 2 '#d73027', 3 '#8073ac')\nset cbrange "
                  "[-0.5:3.5]\n"
                  "unset colorbox\n";
  for (int b = 0; b < mpm::kBranchCount; ++b) {
    std::string cells, lines;
    for (const StabilityRun& r : runs) {
      const bool shown = r.study == "sweep" && r.branch == mpm::kBranchNames[b] && (r.rule == "cfl") == cfl &&
                         r.precision == "float" && (axis.is_nu ? r.rho == kMapRho : r.nu == kMapNu);
      if (!shown) continue;
      const auto index = [](const std::vector<double>& values, double v) {
        return std::find(values.begin(), values.end(), v) - values.begin();
      };
      const double diverged = r.reason == "energy" ? 1 : r.reason == "step" ? 3 : 2;
      const double value = r.stable ? (cfl ? std::log10(0.04 / r.dt) : 0) : (cfl ? std::nan("") : diverged);
      cells +=
          fmt::format("{} {} {:.3g}\n", index(swept_E(), r.E), index(axis.values, axis.is_nu ? r.nu : r.rho), value);
    }
    for (size_t i = 0; i < axis.values.size(); ++i) {
      mpm::Material m = {static_cast<mpm::Branch>(b), 1, kMapNu, kMapRho};
      (axis.is_nu ? m.nu : m.rho) = axis.values[i];
      // Drawn across the cell's height, so that the line turns where the cells do.
      for (const double edge : {-0.5, 0.5})
        lines += fmt::format("{:.3f} {:.3f} {}\n", border(paper_step, m, dx, false), border(paper_step, m, dx, true),
                             static_cast<double>(i) + edge);
    }
    script +=
        fmt::format("$cells << EOD\n{}EOD\n$lines << EOD\n{}EOD\nset title '{}'\nplot $cells using 1:2:3 with image",
                    cells, lines, mpm::kBranchNames[b]);
    if (!cfl)
      script += ", $lines using 1:3 with lines lw 2 lc 'black', $lines using 2:3 with lines lw 2 dt 2 lc 'black'";
    script += "\n";
  }
  return script + "unset multiplot\nreset\n";
}

}  // namespace

std::vector<StabilityCount> count_stability(const std::vector<StabilityRun>& runs) {
  std::vector<StabilityCount> counts;
  for (const StabilityRun& r : runs) {
    auto it = std::find_if(counts.begin(), counts.end(), [&](const StabilityCount& c) {
      return c.study == r.study && c.rule == r.rule && c.precision == r.precision;
    });
    if (it == counts.end()) {
      counts.push_back({r.study, r.rule, r.precision});
      it = counts.end() - 1;
    }
    ++it->runs;
    it->stable += r.stable;
    it->diverged += !r.stable;
    it->garbage += !r.garbage.empty();
    it->latest = std::max(it->latest, r.late);
    it->most_apart = std::max(it->most_apart, r.apart);
  }
  return counts;
}

void write_stability(const std::string& folder, const std::vector<StabilityRun>& runs, const PaperStep& paper_step,
                     double seconds, const Provenance& provenance) {
  write_file(folder + "/stability.csv", to_csv(runs));
  const double dx = stability_dx();
  const MapAxis nu = {"nu", "Poisson ratio", swept_nu(), true};
  const MapAxis rho = {"rho", "density [kg/m^3]", swept_rho(), false};
  const bool drawn =
      run_gnuplot(folder, "stability.gp",
                  map_script(runs, paper_step, nu, false, dx) + map_script(runs, paper_step, rho, false, dx) +
                      map_script(runs, paper_step, nu, true, dx));
  Json json;
  json["counts"] = Json::array();
  for (const StabilityCount& c : count_stability(runs)) {
    json["counts"].push_back({{"study", c.study},
                              {"rule", c.rule},
                              {"precision", c.precision},
                              {"runs", c.runs},
                              {"stable", c.stable},
                              {"diverged", c.diverged},
                              {"garbage", c.garbage},
                              {"latest_detection", c.latest},
                              {"most_apart", c.most_apart}});
  }
  json["garbage"] = Json::array();
  for (const StabilityRun& r : runs) {
    if (r.garbage.empty()) continue;
    json["garbage"].push_back(fmt::format("{}, {} ({} {:g} {:g} {:g}), {}, {}: {}", r.study, r.name, r.branch, r.E,
                                          r.nu, r.rho, r.rule, r.precision, r.garbage));
  }
  json["plots"] = Json::array();
  std::vector<Omission> omitted;
  if (drawn) json["plots"] = {"stability-paper-nu.png", "stability-paper-rho.png", "stability-cfl-nu.png"};
  if (!drawn) omitted.push_back({"plots", "gnuplot did not run"});
  json["omitted"] = to_json(omitted);
  json["runtime"] = {{"seconds", {{"total", seconds}}}};
  save_record(folder + "/stability.json", "stability", provenance, json);
}

}  // namespace physmas::studies
