#include "report/run_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "lift/label_picture.h"
#include "records/json.h"
#include "report/page.h"
#include "report/plot.h"
#include "scene/image_file.h"
#include "splat/row_colors.h"

namespace physmas::report {
namespace {

constexpr int kPicture = 320;  // pixels, the longer side of a label picture

std::string section(const std::string& id, const std::string& title, const std::string& content) {
  return content.empty() ? "" : fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", id, title, content);
}

std::string plain(const Json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return escaped(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  if (!value.is_object()) return escaped(compact_text(value));
  std::string text;
  for (const auto& [key, part] : value.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    text += (text.empty() ? "" : ", ") + escaped(name) + " " + plain(part);
  }
  return text;
}

std::string row_name(const RunRecords& run, const std::string& key) {
  const int r = run.inventory ? run.inventory->find_row(key) : -1;
  return r >= 0 && !run.inventory->rows[static_cast<size_t>(r)].name.empty()
             ? run.inventory->rows[static_cast<size_t>(r)].name
             : key;
}

std::string names(const RunRecords& run, const std::vector<std::string>& keys) {
  std::string text;
  for (size_t i = 0; i < keys.size() && i < 4; ++i) text += (i > 0 ? ", " : "") + row_name(run, keys[i]);
  return keys.size() > 4 ? text + fmt::format(" and {} more", keys.size() - 4) : text;
}

std::string share_bar(double share) {
  const double part = std::clamp(share, 0.0, 1.0);
  return fmt::format(
      "<svg class=\"share\" viewBox=\"0 0 100 8\" preserveAspectRatio=\"none\" aria-hidden=\"true\"><rect "
      "width=\"100\" height=\"8\" rx=\"4\"/>"
      "<rect class=\"{}\" width=\"{:.1f}\" height=\"8\" rx=\"4\"/></svg>",
      part >= 0.5 ? "good" : "bad", 100 * part);
}

std::string swatch(int row, bool residual) {
  const std::array<float, 3> c = splat::row_color(row, residual);
  return fmt::format(
      "<svg class=\"swatch\" viewBox=\"0 0 10 10\" aria-hidden=\"true\"><circle cx=\"5\" cy=\"5\" r=\"5\" "
      "fill=\"rgb({:.0f},{:.0f},{:.0f})\"/></svg>",
      255 * c[0], 255 * c[1], 255 * c[2]);
}

// The four views with every Gaussian in its row's colour.
std::string label_pictures(const RunRecords& run, const Gaussians& gaussians) {
  std::error_code ignored;
  if (!std::filesystem::exists(run.path("spec/lift.json"), ignored)) return "";
  SceneNeeds needs;
  needs.views = true;
  const Scene scene = load_scene(run.path("spec/lift.json"), needs);
  std::string html;
  for (const SceneView& view : scene.views) {
    Camera camera = view.camera;
    const double scale = static_cast<double>(kPicture) / std::max(camera.width, camera.height);
    camera.fx *= scale, camera.fy *= scale, camera.cx *= scale, camera.cy *= scale;
    camera.width = std::max(1, static_cast<int>(std::lround(camera.width * scale)));
    camera.height = std::max(1, static_cast<int>(std::lround(camera.height * scale)));
    const Image picture =
        lift::label_picture(gaussians, run.state->gaussian_row, run.inventory->residual_rows(), camera);
    html += fmt::format(
        "<figure><img alt=\"Parts in the view {}\" width=\"{}\" height=\"{}\" "
        "src=\"{}\"><figcaption>{}</figcaption></figure>",
        escaped(view.name), picture.width, picture.height, data_address("image/jpeg", encode_jpeg(picture, 85)),
        escaped(view.name));
  }
  return "<div class=\"pictures\">" + html + "</div>\n";
}

std::string scores_text(const LabelScores& scores) {
  LabelScores sorted = scores;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (size_t i = 0; i < sorted.size() && i < 3 && sorted[i].second > 0; ++i)
    text += fmt::format("{}{} {:.2g}", i > 0 ? ", " : "", kLabels[static_cast<size_t>(sorted[i].first)].name,
                        sorted[i].second);
  return text;
}

std::string evidence_text(const EvidenceRow& row) {
  std::string text;
  const StatedMaterial& stated = row.stated;
  if (!stated.empty()) {
    text = "stated:";
    if (stated.label) text += std::string(" ") + kLabels[static_cast<size_t>(*stated.label)].name;
    if (stated.E) text += " E " + with_prefix(*stated.E, "Pa");
    if (stated.nu) text += fmt::format(" ν {:.3g}", *stated.nu);
    if (stated.rho) text += fmt::format(" ρ {:.4g} kg/m³", *stated.rho);
  }
  for (const auto& [source, scores] : row.sources) {
    const std::string what = scores_text(scores);
    if (!what.empty()) text += (text.empty() ? "" : "; ") + escaped(source) + ": " + what;
  }
  for (const EvidenceRow::Guard& guard : row.guards) {
    if (guard.applied)
      text += fmt::format("{}guard {} made it {}", text.empty() ? "" : "; ", escaped(guard.name),
                          kLabels[static_cast<size_t>(guard.label)].name);
  }
  if (row.field) {
    text += fmt::format("{}material field: {:.0f} % of the particles, E {} to {}", text.empty() ? "" : "; ",
                        100.0 * static_cast<double>(row.field->sampled) / static_cast<double>(row.field->particles),
                        with_prefix(row.field->E.least, "Pa"), with_prefix(row.field->E.most, "Pa"));
  }
  return text.empty() ? "no evidence: the fallback" : text;
}

std::string gate_chips(const ScreenedCandidate& c) {
  std::string text;
  for (const ScreenedCandidate::Gate& gate : c.gates) {
    if (!gate.passed) text += fmt::format("<span class=\"chip bad\">{}</span> ", escaped(gate.name));
  }
  return text.empty() ? "<span class=\"chip good\">all passed</span>" : text;
}

std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=-:,+") ==
                     std::string::npos &&
                 !text.empty()
             ? text
             : out + "'";
}

// The call that asks for the same run again, into another folder.
std::string make_call(const RunRecords& run, const std::string& variable = "", const std::string& value = "",
                      const std::string& folder = "runs/again") {
  std::string call = "make run";
  bool given = variable.empty();
  for (const auto& [name, old] : run.request) {
    std::string text = old;
    if (name == variable) {
      text = name == "SET" ? old + " " + value : value;
      given = true;
    }
    // make would expand a dollar.
    std::string doubled;
    for (const char c : text) doubled += c == '$' ? std::string("$$") : std::string(1, c);
    call += " " + name + "=" + shell_word(doubled);
  }
  if (!given) call += " " + variable + "=" + shell_word(value);
  return call + " RUN=" + shell_word(folder);
}

}  // namespace

std::string plain_id(const std::string& id) {
  std::string text = id;
  std::replace(text.begin(), text.end(), '-', ' ');
  return text;
}

std::string with_prefix(double value, const char* unit) {
  static constexpr std::array<std::pair<double, const char*>, 4> kPrefixes = {
      {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}, {1, ""}}};
  for (const auto& [size, prefix] : kPrefixes) {
    if (std::abs(value) >= size) return fmt::format("{:.3g} {}{}", value / size, prefix, unit);
  }
  return fmt::format("{:.3g} {}", value, unit);
}

std::string file_link(const std::string& file, const std::string& text) {
  return "<a href=\"" + escaped(file) + "\">" + text + "</a>";
}

std::string actions_section(const RunRecords& run) {
  std::string html;
  if (run.shown != nullptr && run.shown->execution) {
    for (const AchievedAction& a : run.shown->execution->achieved) {
      std::string name = action_name(a.type);
      std::replace(name.begin(), name.end(), '_', ' ');
      html += fmt::format("<li><b>{}</b> of {}: {} {} of {} {} <span class=\"share-text\">{}{:.0f} %</span>{}</li>\n",
                          escaped(name), escaped(names(run, a.rows)), escaped(a.quantity),
                          fmt::format("{:.3g}", a.achieved), fmt::format("{:.3g}", a.requested),
                          escaped(a.unit.empty() ? "(ratio)" : a.unit), share_bar(a.share), 100 * a.share,
                          a.shortfall.empty() ? "" : "<br><small>" + escaped(a.shortfall) + "</small>");
    }
    const auto& still = run.shown->execution->stillness;
    if (still)
      html += fmt::format(
          "<li><b>standing still</b> of {}: drifted {:.2g} m <span class=\"share-text\">{}{:.0f} %</span></li>\n",
          escaped(names(run, still->rows)), still->drift, share_bar(still->share), 100 * still->share);
  }
  if (html.empty() && run.plan && run.plan->actions.empty())
    html = "<li>The prompt asks for no action: things move by gravity alone.</li>";
  std::string notes;
  if (run.plan) {
    for (const std::string& correction : run.plan->corrections) notes += "<li>" + escaped(correction) + "</li>";
  }
  if (!notes.empty())
    notes = "<details><summary>What was assumed while reading the prompt</summary><ul>" + notes + "</ul></details>\n";
  if (html.empty() && notes.empty()) return "";
  return "<div id=\"actions\"><h2>What was asked for, and reached</h2>\n<ul class=\"actions\">" + html + "</ul>\n" +
         notes + "</div>\n";
}

std::string parts_section(const RunRecords& run, const Gaussians* gaussians) {
  if (!run.inventory || !run.state) return "";
  std::string html = gaussians != nullptr ? label_pictures(run, *gaussians) : "";
  html +=
      "<div "
      "class=\"scroll\"><table><thead><tr><th>Part</th><th>Gaussians</th><th>Material</th><th>E</th><th>ν</th><th>ρ</"
      "th><th>Evidence</th></tr></thead><tbody>\n";
  const std::vector<long> counts = run.state->gaussians_per_row();
  for (size_t r = 0; r < run.inventory->rows.size(); ++r) {
    const InventoryRow& row = run.inventory->rows[r];
    if (counts[r] == 0 && row.residual) continue;
    const EvidenceRow* evidence = run.evidence ? &run.evidence->rows.at(r) : nullptr;
    const CandidateRow* material = nullptr;
    if (run.shown != nullptr) {
      for (const CandidateRow& c : run.shown->candidate.rows) {
        if (c.key == row.key()) material = &c;
      }
    }
    const std::string file = run.shown != nullptr ? "candidates/" + run.shown->candidate.id + ".json" : "evidence.json";
    const auto number = [&](const std::string& text) { return file_link(file, text); };
    html += fmt::format("<tr><th scope=\"row\">{}{}<small>{}</small></th><td class=\"n\">{}</td>",
                        swatch(static_cast<int>(r), row.residual), escaped(row.name.empty() ? row.part : row.name),
                        escaped(row.key()), file_link("state.h5", std::to_string(counts[r])));
    html +=
        evidence != nullptr
            ? fmt::format("<td>{} <small>{:.0f} % sure</small></td>",
                          kLabels[static_cast<size_t>(material != nullptr ? material->label : evidence->label)].name,
                          100 * evidence->confidence)
            : "<td>–</td>";
    // Without a candidate, what the evidence says.
    const int label = material != nullptr ? material->label : evidence != nullptr ? evidence->label : -1;
    const double E = material != nullptr ? material->E : evidence != nullptr ? std::pow(10, evidence->log10_E) : 0;
    const double nu = material != nullptr ? material->nu : evidence != nullptr ? evidence->nu : 0;
    // Of the median particle.
    const double rho = material != nullptr                      ? material->rho
                       : evidence != nullptr && evidence->field ? evidence->field->rho.median
                       : label >= 0                             ? kLabels[static_cast<size_t>(label)].rho
                                                                : 0;
    html += label >= 0 ? fmt::format("<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>",
                                     number(with_prefix(E, "Pa")), number(fmt::format("{:.3g}", nu)),
                                     number(fmt::format("{:.4g} kg/m³", rho)))
                       : "<td>–</td><td>–</td><td>–</td>";
    html += fmt::format(
        "<td>{}</td></tr>\n",
        evidence != nullptr ? evidence_text(*evidence) + " " + file_link("evidence.json", "all of it") : "–");
  }
  return section("parts", "Parts and materials", html + "</tbody></table></div>\n");
}

std::string scores_section(const RunRecords& run) {
  if (!run.screen) return "";
  const std::string& file = run.screen_file;
  const auto cell = [&](const std::string& text) { return "<td class=\"n\">" + file_link(file, text) + "</td>"; };
  const auto score = [&](double v) { return cell(fmt::format("{:.2f}", v)); };
  const auto share = [&](const std::optional<double>& v) {
    return v ? score(*v) : std::string("<td class=\"n\">–</td>");
  };
  std::string html =
      fmt::format("<p>A candidate is admitted when it passes every gate and its score Q is at least τ = {}. {}</p>\n",
                  file_link(file, fmt::format("{:g}", run.screen->tau)), escaped(run.screen->reason) + ".");
  html +=
      "<div "
      "class=\"scroll\"><table><thead><tr><th>Candidate</th><th>Q</th><th>Gates</th><th>Achieved</th><th>Still</"
      "th><th>Video</th><th>Parts</th><th>Diversity</th><th>Role</th>"
      "<th>Base</th><th>Density</th><th>Solver</th><th>Penalty</th></tr></thead><tbody>\n";
  std::string details;
  for (const RunRecords::Attempt& a : run.attempts) {
    if (a.screened == nullptr) continue;
    const ScreenedCandidate& c = *a.screened;
    html += fmt::format("<tr{}><th scope=\"row\">{}. {}</th>{}<td>{}</td>{}{}{}{}{}{}{}{}{}{}</tr>\n",
                        c.id == run.accepted ? " class=\"chosen\"" : "", c.rank, escaped(plain_id(c.id)),
                        score(c.score), gate_chips(c), share(c.achieved), share(c.stillness), score(c.video),
                        score(c.part_confidence), score(c.diversity), score(c.role), score(c.base), score(c.density),
                        score(c.solver), score(c.penalty));
    std::string rows;
    for (const ScreenedCandidate::Gate& gate : c.gates) {
      rows += fmt::format(
          "<tr><th scope=\"row\">{}</th><td><span class=\"chip "
          "{}\">{}</span></td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
          escaped(gate.name), gate.passed ? "good" : "bad", gate.passed ? "passed" : "failed",
          file_link(file, plain(gate.measured)), file_link(file, plain(gate.limit)), escaped(gate.advice));
    }
    if (!c.admitted && c.valid)
      rows += fmt::format(
          "<tr><th scope=\"row\">score</th><td><span class=\"chip "
          "bad\">failed</span></td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
          file_link(file, fmt::format("{:.4f}", c.score)),
          file_link(file, fmt::format("at least {:g}", run.screen->tau)), escaped(c.advice));
    details += fmt::format(
        "<details{}><summary>{}</summary><div "
        "class=\"scroll\"><table><thead><tr><th>Gate</th><th></th><th>Measured</th><th>Limit</th><th>What to "
        "try</th></tr></thead>"
        "<tbody>{}</tbody></table></div></details>\n",
        run.accepted.empty() && &a == run.shown ? " open" : "", escaped(plain_id(c.id)), rows);
  }
  return section("scores", "Scores and gates", html + "</tbody></table></div>\n" + details);
}

std::string plots_section(const RunRecords& run, RolloutReader* rollout) {
  if (run.shown == nullptr || !run.shown->execution || !run.state) return "";
  const ExecutionRecord& e = *run.shown->execution;
  std::vector<double> times;
  std::vector<Curve> speeds;
  if (rollout != nullptr) {
    const Carriers& carriers = run.state->carriers;
    const size_t rows = run.state->row_keys.size();
    std::vector<std::vector<double>> mean(rows);
    std::vector<double> fastest;
    for (int t = 0; t < rollout->frame_count(); ++t) {
      times.push_back(rollout->time(t));
      const RolloutFrame frame = rollout->frame(t);
      std::vector<double> sum(rows, 0), count(rows, 0);
      double most = 0;
      for (size_t q = 0; q < frame.velocity.size() / 3; ++q) {
        const size_t i = carriers.empty() ? q : static_cast<size_t>(carriers.gaussian[q]);
        const double v = std::hypot(frame.velocity[3 * q], frame.velocity[3 * q + 1], frame.velocity[3 * q + 2]);
        if (!std::isfinite(v)) continue;
        const auto r = static_cast<size_t>(run.state->gaussian_row[i]);
        sum[r] += v, count[r] += 1;
        most = std::max(most, v);
      }
      for (size_t r = 0; r < rows; ++r)
        mean[r].push_back(count[r] > 0 ? sum[r] / count[r] : std::numeric_limits<double>::quiet_NaN());
      fastest.push_back(most);
    }
    speeds.push_back({"fastest Gaussian", fastest});
    for (size_t r = 0; r < rows && speeds.size() < 6; ++r) {
      if (!mean[r].empty() && std::isfinite(mean[r][0]))
        speeds.push_back({row_name(run, run.state->row_keys[r]) + ", mean", mean[r]});
    }
  } else {
    for (size_t t = 0; t < e.kinetic.size(); ++t)
      times.push_back(static_cast<double>(t) * run.scene->run.time.frame_dt);
  }
  std::vector<double> fallen = e.potential;
  for (double& v : fallen) v -= e.potential.empty() ? 0 : e.potential.front();
  std::vector<Curve> energies = {{"kinetic", e.kinetic}, {"elastic", e.elastic}, {"potential, change", fallen}};
  energies.erase(std::remove_if(energies.begin(), energies.end(), [](const Curve& c) { return c.values.empty(); }),
                 energies.end());
  const std::string file = "rollouts/" + run.shown->candidate.id + ".json";
  std::string html = "<div class=\"plots\">" + line_plot("Energy", "J, of the solver's space", times, energies) +
                     line_plot("Speed", "m/s", times, speeds) + "</div>\n";
  const double stiffest = run.shown->candidate.rows.empty()
                              ? 0
                              : std::max_element(run.shown->candidate.rows.begin(), run.shown->candidate.rows.end(),
                                                 [](const auto& a, const auto& b) { return a.E < b.E; })
                                    ->E;
  std::string grid =
      e.grid.contains("n") && e.grid.at("n").is_number() ? fmt::format("{}³ cells", e.grid.at("n").get<int>()) : "–";
  html += "<dl class=\"facts\">";
  const auto fact = [&](const char* name, const std::string& text) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, file_link(file, text));
  };
  fact("Steps", fmt::format("{} of {}", e.steps,
                            e.smallest_dt == e.largest_dt
                                ? with_prefix(1e6 * e.dt, "µs")
                                : fmt::format("{:.3g} to {:.3g} µs", 1e6 * e.smallest_dt, 1e6 * e.largest_dt)));
  fact("Stiffest part", with_prefix(stiffest, "Pa"));
  fact("Fastest", fmt::format("{:.3g} m/s", e.max_speed));
  fact("Volume ratio J", fmt::format("{:.3g} to {:.3g}", e.J_min, e.J_max));
  fact("Particles", std::to_string(e.particles));
  fact("Grid", grid);
  html += "</dl>\n";
  if (e.diverged)
    html += "<p class=\"warn\">This candidate diverged: " + escaped(e.divergence ? e.divergence->advice : e.reason) +
            "</p>\n";
  return section("motion", "Motion over time", html);
}

std::string error_section(const RunRecords& run) {
  if (!run.error) return "";
  const Json& error = *run.error;
  const double size = error.at("longest_edge").get<double>();
  std::string rows;
  const auto row = [&](const std::string& name, const Json& e, double scale, const char* unit) {
    if (e.at("status") != "valid") {
      rows += fmt::format("<tr><th scope=\"row\">{}</th><td colspan=\"4\">{}</td></tr>\n", escaped(name),
                          escaped(e.at("reason").get<std::string>()));
      return;
    }
    const auto number = [&](const char* field, const char* of) {
      return "<td class=\"n\">" +
             file_link("error.json", fmt::format("{:.3g}{}", scale * e.at(field).get<double>(), of)) + "</td>";
    };
    rows += fmt::format("<tr><th scope=\"row\">{}</th>{}{}<td class=\"n\">{:.1f}</td><td>{}</td></tr>\n", escaped(name),
                        number("estimate", unit), number("bound", unit), e.at("order").get<double>(),
                        e.at("regular").get<bool>() ? "" : "not regular: go by the bound");
  };
  const std::pair<const char*, const char*> names_of[] = {{"position", "Position of the whole scene"},
                                                          {"trajectory_nrmse", "Trajectory in the picture"},
                                                          {"area_log_rmse", "Area in the picture"},
                                                          {"strain_rmse", "Strain in the picture"}};
  for (const Json& e : error.at("measures")) {
    const std::string name = e.at("name").get<std::string>();
    for (const auto& [field, text] : names_of) {
      if (name == field) row(text, e, name == "position" && size > 0 ? 100 / size : 1, name == "position" ? " %" : "");
    }
  }
  for (const Json& e : error.at("rows")) {
    const double edge = e.value("longest_edge", 0.0);
    if (edge > 0) row(row_name(run, e.at("name").get<std::string>()), e, 100 / edge, " %");
  }
  return section(
      "error", "How far the grid may be from the truth",
      fmt::format("<p>The accepted candidate on {} cells along each edge, against the same scene on {} and on {}. "
                  "Position in % of "
                  "the longest edge; the others are the paper's metrics.</p>\n<div "
                  "class=\"scroll\"><table><thead><tr><th></th><th>Error, estimated</th><th>Not "
                  "above</th><th>Order</th><th></th></tr></thead><tbody>\n",
                  error.at("n").get<int>(), error.at("companions").at(0).at("n").get<int>(),
                  error.at("companions").at(1).at("n").get<int>()) +
          rows +
          fmt::format(
              "</tbody></table></div>\n<p class=\"quiet\">Twice the cells halve an error of first order, for about "
              "sixteen times the time: <code>{}</code></p>\n",
              escaped(make_call(run, "SET", fmt::format("grid.n={}", 2 * error.at("n").get<int>())))));
}

std::string omitted_section(const RunRecords& run) {
  std::vector<std::pair<std::string, std::string>> seen;  // "what: why" and the files that say so
  for (const auto& [file, o] : run.omitted) {
    const std::string text = "<b>" + escaped(o.what) + "</b>: " + escaped(o.why);
    auto found = std::find_if(seen.begin(), seen.end(), [&](const auto& s) { return s.first == text; });
    if (found == seen.end()) found = seen.insert(seen.end(), {text, ""});
    found->second += (found->second.empty() ? "" : ", ") + file_link(file, escaped(file));
  }
  std::string html;
  for (const auto& [text, files] : seen)
    html += "<li>" + text + " <details class=\"where\"><summary>where</summary><small>" + files +
            "</small></details></li>\n";
  return section("omitted", "What was left out, and why", html.empty() ? "" : "<ul>" + html + "</ul>\n");
}

std::string times_section(const RunRecords& run) {
  std::vector<Bar> bars;
  double at = 0;
  const auto add = [&](std::string name, double seconds, double bytes) {
    std::replace(name.begin(), name.end(), '-', ' ');
    bars.push_back({name.substr(0, 30), fmt::format("{:.1f} s, {:.0f} MB", seconds, bytes / 1e6), at, seconds});
    at += seconds;
  };
  for (const auto& [stage, time] : run.times) add(stage, time.seconds, time.peak_memory_bytes);
  // A run that was not made by make, or by an earlier version: what the records say.
  const Json::json_pointer total("/seconds/total");
  for (const auto& [what, simulated] : {std::pair("simulate", true), std::pair("render", false)}) {
    for (const RunRecords::Attempt& a : run.attempts) {
      const Json* runtime =
          simulated ? (a.execution ? &a.execution->runtime : nullptr) : (a.render ? &a.render->runtime : nullptr);
      const std::string stage = fmt::format("{}-{}", what, a.candidate.id);
      const bool noted =
          std::any_of(run.times.begin(), run.times.end(), [&](const auto& t) { return t.first == stage; });
      if (noted || runtime == nullptr || !runtime->contains(total) || !runtime->at(total).is_number()) continue;
      const bool has_memory = runtime->contains("peak_memory_bytes") && runtime->at("peak_memory_bytes").is_number();
      add(stage, runtime->at(total).get<double>(), has_memory ? runtime->at("peak_memory_bytes").get<double>() : 0);
    }
  }
  const std::string plot = bar_plot("Seconds and memory of the stages, one after the other", bars);
  if (plot.empty()) return "";
  return std::string(kPageRuntime[0]) +
         section(
             "times", "Time and memory",
             plot +
                 "<p class=\"quiet\">On this machine, with what else ran on it. A stage that was not made again has "
                 "the time of when it was.</p>\n") +
         std::string(kPageRuntime[1]) + "\n";
}

// Which stage failed, what it said, and what to do about it.
std::string failure_section(const RunRecords& run, const StageFailure& failure, const std::string& stage) {
  const char* advice = "Say <code>make run</code> with the same variables again; it goes on where it stopped.";
  switch (failure.code) {
    case static_cast<int>(ExitCode::usage):
      advice =
          "A value that was given is none that this stage takes: the message names it. Change it and say make again.";
      break;
    case static_cast<int>(ExitCode::invalid_input):
      advice =
          "A file is not as expected: the message names it, what was found and what would be right. Change that and "
          "say "
          "make again; what is done already is kept.";
      break;
    case static_cast<int>(ExitCode::provider_failed):
      advice =
          "A model server did not answer as it must. <code>pm-ground check URL</code> says what works with it; "
          "<code>TIMEOUT=</code>, <code>BUDGET=</code> and <code>RETRIES=</code> say how long it is asked.";
      break;
    case static_cast<int>(ExitCode::internal):
      advice =
          "This is a fault of the program, or memory ran out: try <code>THREADS=1</code> and a coarser grid, and "
          "report "
          "the message.";
      break;
    case 137:
      advice =
          "Something ended it by force, as the system does where memory runs out: try <code>THREADS=1</code>, a "
          "coarser "
          "grid (<code>SET=\"grid.n=64\"</code>) or fewer particles (<code>SET=\"particles.max=50000\"</code>).";
      break;
    default:
      break;
  }
  std::string message =
      failure.message.empty() ? "It said nothing; its messages are in make's output." : failure.message;
  std::string html = fmt::format(
      "<p class=\"warn\"><b>The stage “{}” failed</b>{}, exit code {}.</p>\n<pre "
      "class=\"message\">{}</pre>\n<p>{}</p>\n",
      escaped(stage), failure.tool.empty() ? "" : " (" + escaped(failure.tool) + ")", failure.code, escaped(message),
      advice);
  if (!run.request.empty())
    html += "<p>What was asked for:</p>\n<pre>" + escaped(make_call(run, "", "", run.folder)) + "</pre>\n";
  return html;
}

std::string provenance_section(const RunRecords& run) {
  std::string html;
  const std::string again = make_call(run);
  html += "<h3>The same again</h3>\n<pre>" + escaped(again) +
          "</pre>\n<h3>One thing changed</h3>\n<dl class=\"commands\">\n";
  const auto command = [&](const std::string& what, const std::string& call) {
    html += "<dt>" + what + "</dt><dd><pre>" + escaped(call) + "</pre></dd>\n";
  };
  if (run.inventory) {
    for (const InventoryRow& row : run.inventory->rows) {
      if (row.residual) continue;
      const int r = run.inventory->find_row(row.key());
      const bool soft =
          run.evidence &&
          kLabels[static_cast<size_t>(run.evidence->rows.at(static_cast<size_t>(r)).label)].branch != Branch::metal;
      if (!soft && run.inventory->rows.size() > 2) continue;
      command("Another material for " + escaped(row.name.empty() ? row.part : row.name),
              make_call(run, "MATERIAL", row.part + "=Rubber"));
      break;
    }
  }
  command("Another prompt", make_call(run, "PROMPT", "it falls from a little higher"));
  command("A finer grid", make_call(run, "SET", "grid.n=128"));
  command("Accept less, without simulating again (RUN= of this run)", make_call(run, "SET", "screening.tau=0.6"));
  html += "</dl>\n";
  if (!run.settings.empty()) {
    html +=
        "<h3>Settings that differ from the defaults</h3>\n<div "
        "class=\"scroll\"><table><thead><tr><th>Setting</th><th>Here</th><th>Default</th></tr></thead><tbody>\n";
    for (const auto& [name, values] : run.settings)
      html += fmt::format("<tr><th scope=\"row\"><code>{}</code></th><td>{}</td><td>{}</td></tr>\n", escaped(name),
                          plain(values.first), plain(values.second));
    html += "</tbody></table></div>\n";
  }
  html += fmt::format(
      "<h3>Files</h3>\n<p>PhysMAS {}. These files were read for this page; <code>report.json</code> holds their "
      "hashes, <code>make audit</code> compares a whole run.</p>\n<details><summary>{} files</summary><ul "
      "class=\"files\">\n",
      PHYSMAS_VERSION, run.files.size());
  for (const std::string& file : run.files)
    html += "<li>" + file_link(file, escaped(file)) + " <code>" + sha256_of_record(run.path(file)).substr(0, 16) +
            "</code></li>\n";
  return section("provenance", "Do it again, or change one thing", html + "</ul></details>\n");
}

}  // namespace physmas::report
