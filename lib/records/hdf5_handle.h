// What every use of the HDF5 C library in this room shares.
#ifndef PHYSMAS_RECORDS_HDF5_HANDLE_H
#define PHYSMAS_RECORDS_HDF5_HANDLE_H

#include <hdf5.h>

#include <new>

namespace physmas {

// Closes an HDF5 identifier of any kind when it goes out of scope.
class Handle {
 public:
  explicit Handle(hid_t id) : id_(id) {}
  ~Handle() { close(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }
  // Now, with what closing says: what was written may leave the library's caches only here. False after an error.
  bool close() {
    const bool closed = id_ < 0 || H5Idec_ref(id_) >= 0;
    id_ = -1;
    return closed;
  }

 private:
  hid_t id_;
};

// A call that fails for want of memory only: properties, types, spaces and selections of ours. What it returned.
template <class Result>
Result must(Result result) {
  if (result < 0) throw std::bad_alloc();
  return result;
}

// Called before any other use of the library. Our messages replace what it would print to stderr by itself.
void prepare_hdf5();

// For reading; negative where the library refuses the file.
hid_t open_hdf5(const char* path);

}  // namespace physmas

#endif
