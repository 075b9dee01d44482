// The subcommands of pm-eval that make tables.
#ifndef PHYSMAS_TABLES_COMMANDS_H
#define PHYSMAS_TABLES_COMMANDS_H

#include "base/command_line.h"

namespace physmas::tables {

Subcommand add_aggregate_command(Command app);
Subcommand add_suite_command(Command app);    // a registered benchmark against its hashes
Subcommand add_collect_command(Command app);  // its evaluation.json

}  // namespace physmas::tables

#endif
