// An HDF5 file is read once in a process of its own before this one opens it: the library crashes on some damaged files
// (version 1.10 on many), and follows references to other files.
#ifndef PHYSMAS_RECORDS_HDF5_CHECK_H
#define PHYSMAS_RECORDS_HDF5_CHECK_H

#include <hdf5.h>

#include <cstdint>
#include <functional>
#include <string>

namespace physmas {

// What a look at a file does with each block of a dataset's numbers, in order. bytes: as the file has them.
using Hdf5Visit = std::function<void(const std::string& dataset, const void* bytes, size_t size)>;

// Goes through all of an open file: groups, datasets with all their numbers, attributes. Errors (exit code 3) that name
// file and place: links that are not hard, data outside the file (raw files, virtual datasets), other filters than
// shuffle, deflate and checksums, other types than numbers and texts, more than 2^31 numbers or 100,000 objects,
// damage.
void walk_hdf5(hid_t file, const std::string& path, const Hdf5Visit& visit = nullptr);

// Calls `look` with the open file in a process of its own. Errors: those that it throws, and that the file is no
// regular one, that the library cannot open it, crashes on it or takes too long. record: what it should hold, for
// messages.
void inspect_hdf5(const std::string& path, const std::string& record, const std::function<void(hid_t)>& look);

// inspect_hdf5 with walk_hdf5: afterwards this process may open the file.
void check_hdf5(const std::string& path, const std::string& record);

// For the fuzzer, which wants to see a crash: files are looked at in this process from here on.
void check_hdf5_in_this_process();

}  // namespace physmas

#endif
