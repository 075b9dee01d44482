// Half-written files do not outlive a process that Ctrl-C, a hang-up or a termination signal ends, nor the next process
// that writes into their folder.
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
// Removes those files now, in a process that is about to end without unwinding.
void remove_half_files();

// The name under which a file is written until it is whole: ".NAME.PID.START.HOST.tmp" and the suffix. The dot keeps it
// out of listings, the rest says whose it is: process id, when that process started in ticks since boot, and 8
// hexadecimal digits of the host's name and the space of its process ids.
std::string half_file_name(const std::string& name, const std::string& suffix);

// Removes the files of such names in the folder whose processes are gone; those of other hosts stay, which may share
// the folder. Once for each folder; failures are no errors.
void remove_stale_half_files(const std::string& folder);

}  // namespace physmas

#endif
