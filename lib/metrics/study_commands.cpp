// pm-eval study and upr.
#include <fmt/format.h>

#include <memory>
#include <set>

#include "base/error.h"
#include "base/output.h"
#include "metrics/commands.h"
#include "metrics/preference.h"
#include "metrics/study_page.h"

namespace physmas::metrics {
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
  print("{} cases, {} to choose from: give {}/page to respondents, keep {}/key.json\n", key.cases.size(),
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
    print("{} ({} cases)\n", set.name, set.cases);
    for (const std::string& method : record.methods) {
      const Preference& p = set.upr.at(method);
      print("  {:<24} {:5.1f} %  [{:.1f}, {:.1f}]\n", method, p.value, p.low, p.high);
    }
  }
  return 0;
}

}  // namespace

Subcommand add_study_command(Command app) {
  const auto options = std::make_shared<StudyOptions>();
  Command command = app.add_subcommand("study", "Make a blinded forced-choice page from the videos of an evaluation");
  command.add_option("--manifest", options->manifest, "evaluation.json").required();
  command.add_option("--study", options->study, "Which methods stand side by side").one_of({"comparison", "ablation"});
  command.add_option("--seed", options->seed, "Any text; another one gives other codes");
  command.add_option("--out", options->out, "Folder for page/ and key.json").required();
  return {command, [options](const CommonOptions&) { return study(*options); }};
}

Subcommand add_upr_command(Command app) {
  const auto options = std::make_shared<UprOptions>();
  Command command = app.add_subcommand("upr", "User preference rates, with intervals, from the answers of a study");
  command.add_option("--key", options->key, "key.json of the study").required();
  command.add_option("--answers", options->answers, "Answer files, one per respondent").required();
  command.add_option("--resamples", options->resamples, "Bootstrap draws").between(1, 1000000);
  command.add_option("--seed", options->seed, "Of the draws").not_negative();
  command.add_option("--out", options->out, "upr.json to write").required();
  return {command, [options](const CommonOptions&) { return upr(*options); }};
}

}  // namespace physmas::metrics
