// Half-written files do not outlive a process that Ctrl-C, a hang-up or a termination signal ends.
#ifndef PHYSMAS_BASE_HALF_FILES_H
#define PHYSMAS_BASE_HALF_FILES_H

#include <string>

namespace physmas {

// From here on SIGINT, SIGTERM and SIGHUP remove the file before they end the process with the status that they would
// have given it. A signal that was ignored (nohup) or has a handler already keeps what it does. Of more than 16 files
// at a time the others stay.
void remove_on_signal(const std::string& path);
// No longer: the file is finished, or gone.
void keep_on_signal(const std::string& path);

}  // namespace physmas

#endif
