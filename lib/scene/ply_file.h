// PLY containers (Turk 1994): header, layout and typed values of ascii and binary files, for the Gaussian readers.
#ifndef PHYSMAS_SCENE_PLY_FILE_H
#define PHYSMAS_SCENE_PLY_FILE_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace physmas {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  // of the value, or of a list's entries
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  // lists only
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;  // rows
  std::vector<PlyProperty> properties;
  size_t begin = 0;     // byte of the file at which its first row starts
  size_t row_size = 0;  // bytes per row; 0 in ascii files and for elements with lists

  // Position in `properties`, or -1.
  int find(const std::string& property) const;
};

// A parsed PLY file over bytes that it does not own. The constructor reads the header, and checks that the body holds
// exactly the rows that the header declares before anybody allocates for them. Errors (exit code 3) name the file and
// the header line, element or byte.
class PlyFile {
 public:
  // path: for messages. bytes: the whole file; must outlive this object.
  PlyFile(std::string path, const std::string& bytes);

  // Whether `bytes` start as a PLY file does.
  static bool is_ply(const std::string& bytes);

  const std::string& path() const { return path_; }
  PlyFormat format() const { return format_; }
  const std::vector<PlyElement>& elements() const { return elements_; }
  // The element of that name, or null.
  const PlyElement* find(const std::string& name) const;

  // Calls visit(row, values) for every row in file order with the values of the wanted properties (positions in
  // `element.properties`, no lists, in that order). Every value fits a double exactly; float32 text is rounded once.
  void read_rows(const PlyElement& element, const std::vector<int>& wanted,
                 const std::function<void(size_t row, const double* values)>& visit) const;

 private:
  void parse_header();
  void locate_binary_elements();
  void locate_text_elements();
  std::string next_token(size_t& at, const PlyElement& element, uint64_t row) const;
  double text_value(const std::string& token, PlyType type, const PlyElement& element, const PlyProperty& property,
                    uint64_t row) const;
  uint64_t text_list_length(size_t& at, const PlyElement& element, const PlyProperty& property, uint64_t row) const;
  double binary_value(size_t at, PlyType type) const;

  std::string path_;
  const std::string& bytes_;
  PlyFormat format_ = PlyFormat::ascii;
  std::vector<PlyElement> elements_;
  size_t body_ = 0;  // byte after the header
};

// Bytes of a value in a binary file.
size_t ply_type_size(PlyType type);

}  // namespace physmas

#endif
