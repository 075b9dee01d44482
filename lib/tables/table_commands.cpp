// pm-eval aggregate.
#include <fmt/format.h>

#include <memory>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/output.h"
#include "tables/aggregate.h"
#include "tables/commands.h"

namespace physmas::tables {
namespace {

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
      print("{}\n", table.markdown());
    } else {
      empty += (empty.empty() ? "" : ", ") + table.name;
    }
  }
  if (!empty.empty()) print("Nothing was measured for {}.\n", empty);
  return 0;
}

}  // namespace

Subcommand add_aggregate_command(Command app) {
  const auto options = std::make_shared<AggregateOptions>();
  Command command = app.add_subcommand("aggregate", "Tables 1 to 5 of the paper from an evaluation's records");
  command.add_option("--manifest", options->manifest, "evaluation.json").required();
  command.add_option("--upr", options->rates, "upr.json of the comparison and of the ablation");
  command.add_option("--out", options->out, "Folder for the tables").required();
  command.add_flag("--draft", options->draft, "Write tables with \"invalid\" in place of what cannot be computed");
  return {command, [options](const CommonOptions&) { return aggregate(*options); }};
}

}  // namespace physmas::tables
