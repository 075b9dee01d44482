// pm-eval study, upr and aggregate.
#include <fmt/format.h>

#include <memory>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "eval/aggregate.h"
#include "eval/commands.h"
#include "eval/preference.h"
#include "eval/study_page.h"

namespace physmas::eval {
namespace {

struct StudyOptions {
  std::string manifest, study = "comparison", seed = "0", out;
};

int study(const StudyOptions& options) {
  const Evaluation evaluation = load_evaluation(options.manifest);
  const StudyKey key = make_study(evaluation, options.study, options.seed);
  write_study_page(options.out, evaluation, key);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"study", options.study}, {"seed", options.seed}};
  provenance.add_input(options.manifest);
  save_study_key(options.out + "/key.json", key, provenance);
  fmt::print("{} cases, {} to choose from: give {}/page to respondents, keep {}/key.json\n", key.cases.size(),
             key.methods.size(), options.out, options.out);
  return 0;
}

struct UprOptions {
  std::string key, out;
  std::vector<std::string> answers;
  long resamples = 2000, seed = 0;
};

int upr(const UprOptions& options) {
  const StudyKey key = load_study_key(options.key);
  std::vector<StudyAnswers> answers;
  std::set<std::string> respondents;
  for (const std::string& path : options.answers) {
    answers.push_back(load_study_answers(path, key));
    if (!respondents.insert(answers.back().respondent).second)
      throw invalid_input(
          {path, "/respondent", "\"" + one_line(answers.back().respondent, 80) + "\" again", "every respondent once"});
  }
  const UprRecord record = preference_rates(key, answers, options.resamples, options.seed);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"resamples", std::to_string(options.resamples)}, {"seed", std::to_string(options.seed)}};
  provenance.add_input(options.key);
  for (const std::string& path : options.answers) provenance.add_input(path);
  save_upr(options.out, record, provenance);
  for (const UprRecord::Set& set : record.sets) {
    fmt::print("{} ({} cases)\n", set.name, set.cases);
    for (const std::string& method : record.methods) {
      const Preference& p = set.upr.at(method);
      fmt::print("  {:<24} {:5.1f} %  [{:.1f}, {:.1f}]\n", method, p.value, p.low, p.high);
    }
  }
  return 0;
}

struct AggregateOptions {
  std::string manifest, out;
  std::vector<std::string> rates;
  bool draft = false;
};

void write_table(const std::string& folder, const Table& table) {
  write_file(folder + "/" + table.name + ".tex", table.latex());
  write_file(folder + "/" + table.name + ".md", table.markdown());
  write_file(folder + "/" + table.name + ".csv", table.csv());
}

int aggregate(const AggregateOptions& options) {
  const Evaluation evaluation = load_evaluation(options.manifest);
  std::vector<UprRecord> rates;
  for (const std::string& path : options.rates) {
    rates.push_back(load_upr(path));
    for (size_t i = 0; i + 1 < rates.size(); ++i) {
      if (rates[i].study == rates.back().study)
        throw invalid_input({path, "/study", "\"" + rates[i].study + "\" again", "each study once"});
    }
  }
  const Aggregate aggregate(evaluation, rates);
  write_table(options.out, aggregate.case_table());
  const std::vector<std::string> lacking = aggregate.lacking();
  if (!lacking.empty() && !options.draft)
    throw invalid_input({options.manifest, "/required", fmt::format("{} invalid: {}", lacking.size(), lacking.front()),
                         "a valid record for each", fmt::format("{}/cases.md lists every result", options.out)});
  for (const std::string& line : lacking) log_warning(line);
  std::vector<Table> tables = aggregate.paper_tables();
  for (Table& table : aggregate.detail_tables()) tables.push_back(std::move(table));
  std::string empty;
  for (const Table& table : tables) {
    write_table(options.out, table);
    if (table.has_numbers()) {
      fmt::print("{}\n", table.markdown());
    } else {
      empty += (empty.empty() ? "" : ", ") + table.name;
    }
  }
  if (!empty.empty()) fmt::print("Nothing was measured for {}.\n", empty);
  return 0;
}

}  // namespace

Command add_study_command(CLI::App& app) {
  const auto options = std::make_shared<StudyOptions>();
  CLI::App* command = app.add_subcommand("study", "Make a blinded forced-choice page from the videos of an evaluation");
  command->add_option("--manifest", options->manifest, "evaluation.json")->required();
  command->add_option("--study", options->study, "Which methods stand side by side")
      ->check(CLI::IsMember({"comparison", "ablation"}));
  command->add_option("--seed", options->seed, "Any text; another one gives other codes");
  command->add_option("--out", options->out, "Folder for page/ and key.json")->required();
  return {command, [options](const CommonOptions&) { return study(*options); }};
}

Command add_upr_command(CLI::App& app) {
  const auto options = std::make_shared<UprOptions>();
  CLI::App* command = app.add_subcommand("upr", "User preference rates, with intervals, from the answers of a study");
  command->add_option("--key", options->key, "key.json of the study")->required();
  command->add_option("--answers", options->answers, "Answer files, one per respondent")->required();
  command->add_option("--resamples", options->resamples, "Bootstrap draws")->check(CLI::Range(1, 1000000));
  command->add_option("--seed", options->seed, "Of the draws")->check(CLI::NonNegativeNumber);
  command->add_option("--out", options->out, "upr.json to write")->required();
  return {command, [options](const CommonOptions&) { return upr(*options); }};
}

Command add_aggregate_command(CLI::App& app) {
  const auto options = std::make_shared<AggregateOptions>();
  CLI::App* command = app.add_subcommand("aggregate", "Tables 1 to 5 of the paper from an evaluation's records");
  command->add_option("--manifest", options->manifest, "evaluation.json")->required();
  command->add_option("--upr", options->rates, "upr.json of the comparison and of the ablation");
  command->add_option("--out", options->out, "Folder for the tables")->required();
  command->add_flag("--draft", options->draft, "Write tables with \"invalid\" in place of what cannot be computed");
  return {command, [options](const CommonOptions&) { return aggregate(*options); }};
}

}  // namespace physmas::eval
