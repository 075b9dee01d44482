// Texts of variable length in HDF5 attributes, which h5py writes by default.
#ifndef PHYSMAS_RECORDS_HDF5_TEXT_H
#define PHYSMAS_RECORDS_HDF5_TEXT_H

#include <hdf5.h>

#include <string>

namespace physmas {

constexpr size_t kMaxHdf5Text = size_t{64} << 20;  // bytes of a text, of either kind

// attribute: one text of variable length, in a file that is open for reading. path: that file. where: the attribute,
// for messages. Errors: exit code 3.
//
// The library's own reading is not used for these: it takes as much memory as the attribute asks for, and version 1.10
// (Debian 12) copies the stored bytes into it without comparing the two lengths.
std::string read_variable_text(hid_t attribute, const std::string& path, const std::string& where);

}  // namespace physmas

#endif
