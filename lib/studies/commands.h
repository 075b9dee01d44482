// The subcommands of pm-eval that study the solver itself.
#ifndef PHYSMAS_STUDIES_COMMANDS_H
#define PHYSMAS_STUDIES_COMMANDS_H

#include "base/command_line.h"
#include "studies/stability.h"

namespace physmas::studies {

Subcommand add_accuracy_command(Command app, const PaperStep& paper_step);
Subcommand add_error_command(Command app);
Subcommand add_error_study_command(Command app);
Subcommand add_stability_command(Command app, const PaperStep& paper_step);
Subcommand add_stiff_command(Command app);
Subcommand add_verification_command(Command app);

}  // namespace physmas::studies

#endif
