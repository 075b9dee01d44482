// pm-eval suite and collect.
#include <fmt/format.h>

#include <memory>

#include "base/file.h"
#include "base/output.h"
#include "records/json.h"
#include "tables/commands.h"
#include "tables/suite.h"

namespace physmas::tables {
namespace {

struct SuiteOptions {
  std::string suite, makefile, results, out;
  std::vector<std::string> cases;
  bool registers = false;
};

int check_suite(const SuiteOptions& options) {
  const Suite suite = load_suite(options.suite);
  if (options.registers) {
    register_suite(suite);
    print("{} files registered\n", suite.hashes.size());
  }
  require_registered(suite);
  if (!options.makefile.empty()) write_file(options.makefile, suite_makefile(suite, options.cases));
  return 0;
}

int collect(const SuiteOptions& options) {
  const Suite suite = load_suite(options.suite);
  require_registered(suite);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.add_input(options.suite);
  for (const SuiteCase& c : suite.cases) {
    provenance.add_input(c.example);
    provenance.add_input(c.reference);
  }
  save_record(options.out, "evaluation", provenance, collect_evaluation(suite, options.results, options.cases));
  return 0;
}

}  // namespace

Subcommand add_suite_command(Command app) {
  const auto options = std::make_shared<SuiteOptions>();
  Command command = app.add_subcommand("suite", "Check a registered benchmark against its hashes");
  command.add_option("--suite", options->suite, "suite.json, with suite.sha256 beside it").required();
  command.add_flag("--register", options->registers, "Write suite.sha256 for the files as they are now");
  command.add_option("--cases", options->cases, "Only these in the makefile");
  command.add_option("--makefile", options->makefile, "Also write what pipelines/evaluate.mk needs to know");
  return {command, [options](const CommonOptions&) { return check_suite(*options); }};
}

Subcommand add_collect_command(Command app) {
  const auto options = std::make_shared<SuiteOptions>();
  Command command = app.add_subcommand("collect", "Make evaluation.json of the results of a registered benchmark");
  command.add_option("--suite", options->suite, "suite.json").required();
  command.add_option("--results", options->results, "Folder of the evaluation: results/CASE/METHOD/result.tsv")
      .required();
  command.add_option("--cases", options->cases, "Only these");
  command.add_option("--out", options->out, "evaluation.json to write; in the folder of the results").required();
  return {command, [options](const CommonOptions&) { return collect(*options); }};
}

}  // namespace physmas::tables
