// A thin, strict wall around the HDF5 C library: hostile files give one-line Errors, writing is atomic and
// deterministic (no timestamps are stored).
#ifndef PHYSMAS_RECORDS_HDF5_FILE_H
#define PHYSMAS_RECORDS_HDF5_FILE_H

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/file.h"
#include "records/provenance.h"

namespace physmas {

// Reads one file, after a look at all of it in a process of its own (records/hdf5_check.h). Every method throws an
// Error (exit code 3) that names the file, the dataset, what was found and what was expected: missing or cut files,
// missing datasets, other types, other shapes, values that are not finite.
class Hdf5Reader {
 public:
  // record: the expected value of the root attribute `schema`, without "physmas/" and "/1".
  Hdf5Reader(const std::string& path, const std::string& record);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  const std::string& path() const { return path_; }
  bool exists(const std::string& name) const;
  // Refuses a file with another dataset than these, by path; none of them has to be there.
  void allow_only(const std::vector<std::string>& datasets) const;
  // Names of the links in a group, sorted.
  std::vector<std::string> names_in(const std::string& group) const;
  std::vector<uint64_t> shape(const std::string& dataset) const;

  // Whole datasets. `expected` gives the shape that must match; UINT64_MAX stands for any extent. `limit` bounds the
  // number of elements, which is checked before memory is taken. Float data must be finite.
  std::vector<float> read_float(const std::string& dataset, const std::vector<uint64_t>& expected,
                                uint64_t limit = uint64_t{1} << 31) const;
  std::vector<int32_t> read_int(const std::string& dataset, const std::vector<uint64_t>& expected,
                                uint64_t limit = uint64_t{1} << 31) const;
  std::vector<uint8_t> read_byte(const std::string& dataset, const std::vector<uint64_t>& expected,
                                 uint64_t limit = uint64_t{1} << 31) const;
  // One slab along the first axis: elements [index, index + count) of it.
  std::vector<float> read_float_slab(const std::string& dataset, uint64_t index, uint64_t count) const;

  std::vector<double> read_attribute(const std::string& object, const std::string& name, size_t count) const;
  // One text, of fixed length as we write it or of variable length as h5py does.
  std::string read_text_attribute(const std::string& object, const std::string& name) const;

  Error invalid(const std::string& where, const std::string& found, const std::string& expected) const;

 private:
  friend class Hdf5Writer;
  // Of a file that is open already, and stays so.
  Hdf5Reader(const std::string& path, int64_t file);
  template <class T>
  std::vector<T> read(const std::string& dataset, const std::vector<uint64_t>& expected, uint64_t limit) const;
  void add_datasets(const std::string& group, std::vector<std::string>& names) const;
  std::string path_, record_;
  int64_t file_ = -1;
};

// Writes one file, atomically: nothing appears until commit(), which reads the file back and compares it with what it
// was given. What cannot be written is an Error (exit code 3).
class Hdf5Writer {
 public:
  // Writes the root attributes `schema` and `provenance` (as JSON text).
  Hdf5Writer(const std::string& path, const std::string& record, const Provenance& provenance);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  // Parent groups are made as needed. compress: byte shuffle and deflate level 1.
  void write_float(const std::string& dataset, const std::vector<uint64_t>& shape, const float* data,
                   bool compress = true);
  void write_int(const std::string& dataset, const std::vector<uint64_t>& shape, const int32_t* data,
                 bool compress = true);
  void write_byte(const std::string& dataset, const std::vector<uint64_t>& shape, const uint8_t* data,
                  bool compress = true);

  // A float dataset that grows by one slab along its first axis at a time, chunked by slab.
  void create_series(const std::string& dataset, const std::vector<uint64_t>& slab_shape);
  void append_slab(const std::string& dataset, const float* data);

  void write_attribute(const std::string& object, const std::string& name, const std::vector<double>& values);
  void write_text_attribute(const std::string& object, const std::string& name, const std::string& text);
  void make_group(const std::string& group);

  // Returns whether the file changed.
  bool commit();

 private:
  struct Sum {
    uint64_t bytes = 0;
    uint32_t crc = 0;
  };
  struct Attribute {
    std::string object, name;
    std::vector<double> values;  // or
    std::string text;
  };
  template <class T>
  void write(const std::string& dataset, const std::vector<uint64_t>& shape, const T* data, bool compress);
  // What a dataset is given.
  void note(const std::string& dataset, const void* data, size_t size);
  void compare(int64_t file) const;
  [[noreturn]] void fail(const std::string& where) const;
  std::map<std::string, Sum> sums_;
  std::vector<Attribute> attributes_;
  std::string path_, record_;
  AtomicFile out_;
  int64_t file_ = -1;
};

}  // namespace physmas

#endif
