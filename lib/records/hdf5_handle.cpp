#include "records/hdf5_handle.h"

#include <new>

#include "base/foreign_lines.h"

namespace physmas {

void prepare_hdf5() {
  static const bool prepared = [] {
    // After a failed flush (a full disk) the library's exit handler would try again and crash. Every file is closed by
    // its owner here, so nothing is left for that handler to do. It must be switched off before the library starts.
    H5dont_atexit();
    // Starting can lack memory, and until then the library prints.
    const ForeignLines kept;
    if (H5open() < 0 || H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) < 0) throw std::bad_alloc();
    return true;
  }();
  static_cast<void>(prepared);
}

hid_t open_hdf5(const char* path) {
  prepare_hdf5();
  // Locking fails on read-only and some network file systems, and nothing here writes in place.
  const Handle access(must(H5Pcreate(H5P_FILE_ACCESS)));
  must(H5Pset_file_locking(access, false, true));
  return H5Fopen(path, H5F_ACC_RDONLY, access);
}

}  // namespace physmas
