// The subcommands of pm-eval that make tables.
#ifndef PHYSMAS_TABLES_COMMANDS_H
#define PHYSMAS_TABLES_COMMANDS_H

#include "base/command_line.h"

namespace physmas::tables {

Subcommand add_aggregate_command(CLI::App& app);
Subcommand add_suite_command(CLI::App& app);    // a registered benchmark against its hashes
Subcommand add_collect_command(CLI::App& app);  // its evaluation.json

}  // namespace physmas::tables

#endif
