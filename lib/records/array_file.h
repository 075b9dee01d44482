// Numeric arrays by name from .npz files (numpy) and JSON.
#ifndef PHYSMAS_RECORDS_ARRAY_FILE_H
#define PHYSMAS_RECORDS_ARRAY_FILE_H

#include <map>
#include <string>
#include <vector>

namespace physmas {

struct Array {
  std::vector<size_t> shape;
  std::vector<double> values;  // [product of shape], row-major; not checked for NaN
};

// The bytes of a .npy file (format 1 to 3): little-endian f4, f8, i1, i4, i8, u1 or b1 in C order, at most 2^26 values.
// file, field: for messages. Errors: exit code 3.
Array parse_npy(const std::string& bytes, const std::string& file, const std::string& field);

// The arrays of these names from a .npz file, or from a JSON object of nested lists (numbers, true, false; null is
// NaN). Which it is decides the content, not the name. Errors (exit code 3): a name that is missing, lists of uneven
// length, an archive that is cut, damaged, encrypted or names something twice, arrays above 2^29 bytes.
std::map<std::string, Array> load_arrays(const std::string& path, const std::vector<std::string>& names);
// The same from the file's bytes; `file` is only named in messages.
std::map<std::string, Array> parse_arrays(const std::string& bytes, const std::string& file,
                                          const std::vector<std::string>& names);

// "[1, 50, 256, 2]", for messages.
std::string shape_text(const std::vector<size_t>& shape);

}  // namespace physmas

#endif
