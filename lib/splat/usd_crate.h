// Binary USD layers (.usdc), as far as animated attributes need them.
#ifndef PHYSMAS_SPLAT_USD_CRATE_H
#define PHYSMAS_SPLAT_USD_CRATE_H

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/file.h"

namespace physmas::splat {

// Kinds of values, by their numbers in the format.
enum class UsdType : uint8_t {
  int_ = 3,
  half = 7,
  float_ = 8,
  double_ = 9,
  string = 10,
  token = 11,
  quatf = 17,
  quath = 18,
  vec3f = 24,
  vec3h = 25,
  token_vector = 41,
  specifier = 42,
  variability = 44,
  time_samples = 46,
  double_vector = 48
};

// A value's place in the file, or the value itself where that is small.
using UsdValue = uint64_t;

// Writes one layer: values first, as they come, then the tree of prims and attributes that refers to them (the crate
// format, version 0.8.0, which OpenUSD reads since 2019). Values may be used several times.
class UsdCrate {
 public:
  explicit UsdCrate(const std::string& path);

  UsdValue token(const std::string& text);
  UsdValue string(const std::string& text);
  UsdValue integer(int value);
  UsdValue real(double value);
  UsdValue tokens(const std::vector<std::string>& texts);
  // values: `count` elements of `type` as they lie in memory, little-endian.
  UsdValue array(UsdType type, const void* values, size_t count, size_t element_bytes);
  // times ascend; as many values, all of one type.
  UsdValue samples(const std::vector<double>& times, const std::vector<UsdValue>& values);

  // Of the layer itself: up axis, frame rate and so on.
  void set_metadata(const std::string& name, UsdValue value);
  // A prim below `parent` ("" for the root), whose path it returns; specifier def.
  std::string add_prim(const std::string& parent, const std::string& name, const std::string& type);
  // An attribute of a prim; `field` is default or timeSamples.
  void add_attribute(const std::string& prim, const std::string& name, const std::string& type, bool uniform,
                     const std::string& field, UsdValue value);

  // Writes the tree. Returns whether the file changed.
  bool commit();

 private:
  using Fields = std::vector<std::pair<std::string, UsdValue>>;
  struct Node {
    std::string name, type;
    bool is_prim = false;
    Fields fields;
    std::vector<size_t> children, attributes;
  };
  uint32_t token_index(const std::string& text);
  uint64_t align();
  struct Tree;
  void add_paths(const std::vector<size_t>& siblings, Tree& tree);
  void write_packed(const std::string& bytes);
  void write_numbers(const std::vector<int32_t>& numbers);
  std::vector<size_t> below(size_t node) const;
  template <class T>
  void put(const T& value);

  FileWriter file_;
  std::vector<std::string> tokens_;
  std::map<std::string, uint32_t> token_numbers_;
  std::vector<uint32_t> strings_;  // tokens
  std::vector<Node> nodes_;        // 0: the root
  std::map<std::string, size_t> paths_;
};

}  // namespace physmas::splat

#endif
