// PLY containers (Turk 1994): header, layout and typed values of ascii and binary files, for the Gaussian readers.
#ifndef PHYSMAS_SCENE_PLY_FILE_H
#define PHYSMAS_SCENE_PLY_FILE_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
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

// The bytes of a file that is read from its start to its end, or of memory.
class PlyBytes {
 public:
  // bytes: must outlive this object.
  explicit PlyBytes(const std::string& bytes) : memory_(&bytes), size_(bytes.size()) {}
  // Opens a regular file, of which a few megabytes are held at a time. Errors (exit code 3) name it.
  explicit PlyBytes(const std::string& path, uint64_t limit);
  ~PlyBytes();
  PlyBytes(const PlyBytes&) = delete;
  PlyBytes& operator=(const PlyBytes&) = delete;

  uint64_t size() const { return size_; }
  bool in_memory() const { return memory_ != nullptr; }
  const std::string& memory() const { return *memory_; }  // only then
  // `count` bytes from `at` on, all of them inside the file; they stay until the next call.
  const char* view(uint64_t at, size_t count) const;

 private:
  const std::string* memory_ = nullptr;
  std::string path_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
  mutable std::string held_;
  mutable uint64_t begin_ = 0;  // of `held_` in the file
};

// A parsed PLY file over bytes that it does not own. The constructor reads the header, and checks that the body holds
// the rows that the header declares before anybody allocates for them. Errors (exit code 3) name the file and the
// header line, element or byte.
class PlyFile {
 public:
  // path: for messages. bytes: the whole file; must outlive this object.
  PlyFile(std::string path, const std::string& bytes);
  // The same from a file. One of text or with lists is read whole, another one piece by piece.
  explicit PlyFile(const std::string& path, uint64_t limit);
  PlyFile(const PlyFile&) = delete;
  PlyFile& operator=(const PlyFile&) = delete;

  // Whether `bytes` start as a PLY file does.
  static bool is_ply(const std::string& bytes);

  const std::string& path() const { return path_; }
  PlyFormat format() const { return format_; }
  // Of the header, without the word itself, as they stand there; at most 1024.
  const std::vector<std::string>& comments() const { return comments_; }
  // Bytes after the last row.
  uint64_t trailing() const { return trailing_; }
  const std::vector<PlyElement>& elements() const { return elements_; }
  // The element of that name, or null.
  const PlyElement* find(const std::string& name) const;

  // Calls visit(row, values) for every row in file order with the values of the wanted properties (positions in
  // `element.properties`, no lists, in that order). Every value fits a double exactly; float32 text is rounded once.
  void read_rows(const PlyElement& element, const std::vector<int>& wanted,
                 const std::function<void(size_t row, const double* values)>& visit) const;

 private:
  void read();
  void parse_header(const std::string& text);
  void locate_binary_elements();
  void locate_text_elements();
  const std::string& text() const;
  std::string next_token(size_t& at, const PlyElement& element, uint64_t row) const;
  double text_value(const std::string& token, PlyType type, const PlyElement& element, const PlyProperty& property,
                    uint64_t row) const;
  uint64_t text_list_length(size_t& at, const PlyElement& element, const PlyProperty& property, uint64_t row) const;
  double binary_value(size_t at, PlyType type) const;

  std::string path_;
  std::string whole_;  // of a file that had to be read whole
  std::unique_ptr<PlyBytes> bytes_;
  PlyFormat format_ = PlyFormat::ascii;
  std::vector<std::string> comments_;
  uint64_t trailing_ = 0;
  std::vector<PlyElement> elements_;
  size_t body_ = 0;  // byte after the header
};

// Bytes of a value in a binary file.
size_t ply_type_size(PlyType type);

}  // namespace physmas

#endif
