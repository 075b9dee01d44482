#include "splat/usd_crate.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/error.h"

namespace physmas::splat {
namespace {

constexpr uint64_t kInlined = uint64_t{1} << 62, kArray = uint64_t{1} << 63;
constexpr uint64_t kPayload = (uint64_t{1} << 48) - 1;
constexpr size_t kHeadBytes = 88;
// Kinds of specs.
constexpr int32_t kAttribute = 1, kPrim = 6, kRoot = 7;
// What comes after an entry of the tree of paths: a sibling, a child, or nothing. Of one with both, the child comes
// next and the number says how many entries later the sibling does.
constexpr int32_t kSibling = 0, kChild = -1, kNothing = -2;

UsdValue value_at(UsdType type, uint64_t payload, uint64_t flags = 0) {
  return flags | static_cast<uint64_t>(type) << 48 | (payload & kPayload);
}

// A block of LZ4 that is one run of literals, after the byte that says that there is one block.
std::string literals(const std::string& bytes) {
  std::string out(1, '\0');
  const size_t length = bytes.size();
  out += static_cast<char>(std::min<size_t>(length, 15) << 4);
  if (length >= 15) {
    size_t left = length - 15;
    for (; left >= 255; left -= 255) out += '\xff';
    out += static_cast<char>(left);
  }
  return out + bytes;
}

// Differences from number to number: a common one (0), two bits for each that tell its size in bytes (0, 1, 2 or 4),
// and those bytes.
std::string differences(const std::vector<int32_t>& numbers) {
  std::string codes((numbers.size() + 3) / 4, '\0'), bytes;
  int32_t before = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    // In unsigned numbers, which wrap around.
    const auto d = static_cast<int32_t>(static_cast<uint32_t>(numbers[i]) - static_cast<uint32_t>(before));
    before = numbers[i];
    const int code = d == 0 ? 0 : d == static_cast<int8_t>(d) ? 1 : d == static_cast<int16_t>(d) ? 2 : 3;
    codes[i / 4] = static_cast<char>(codes[i / 4] | code << 2 * (i % 4));
    const int size = code == 3 ? 4 : code;
    for (int k = 0; k < size; ++k) bytes += static_cast<char>(static_cast<uint32_t>(d) >> 8 * k & 255);
  }
  return std::string(4, '\0') + codes + bytes;
}

}  // namespace

struct UsdCrate::Tree {
  std::vector<int32_t> nodes, names, jumps;
};

UsdCrate::UsdCrate(const std::string& path) : file_(path) {
  file_.write(std::string(kHeadBytes, '\0'));
  nodes_.push_back({});
  nodes_[0].is_prim = true;
  paths_[""] = 0;
  token_index("");  // 0
}

template <class T>
void UsdCrate::put(const T& value) {
  file_.write(&value, sizeof(T));
}

uint64_t UsdCrate::align() {
  while (file_.written() % 8 != 0) put(char{0});
  if (file_.written() > kPayload) throw internal_error("a USD file beyond 2^48 bytes");
  return file_.written();
}

uint32_t UsdCrate::token_index(const std::string& text) {
  const auto [found, added] = token_numbers_.emplace(text, static_cast<uint32_t>(tokens_.size()));
  if (added) tokens_.push_back(text);
  return found->second;
}

UsdValue UsdCrate::token(const std::string& text) {
  return value_at(UsdType::token, token_index(text), kInlined);
}

UsdValue UsdCrate::string(const std::string& text) {
  strings_.push_back(token_index(text));
  return value_at(UsdType::string, strings_.size() - 1, kInlined);
}

UsdValue UsdCrate::integer(int value) {
  return value_at(UsdType::int_, static_cast<uint32_t>(value), kInlined);
}

UsdValue UsdCrate::real(double value) {
  // As a float where that is exact.
  const auto single = static_cast<float>(value);
  if (single == value) {
    uint32_t bits;
    std::memcpy(&bits, &single, sizeof(bits));
    return value_at(UsdType::double_, bits, kInlined);
  }
  const uint64_t place = align();
  put(value);
  return value_at(UsdType::double_, place);
}

UsdValue UsdCrate::tokens(const std::vector<std::string>& texts) {
  const uint64_t place = align();
  put(static_cast<uint64_t>(texts.size()));
  for (const std::string& text : texts) put(token_index(text));
  return value_at(UsdType::token_vector, place);
}

UsdValue UsdCrate::array(UsdType type, const void* values, size_t count, size_t element_bytes) {
  if (count == 0) return value_at(type, 0, kArray);
  const uint64_t place = align();
  put(static_cast<uint64_t>(count));
  file_.write(values, count * element_bytes);
  return value_at(type, place, kArray);
}

UsdValue UsdCrate::samples(const std::vector<double>& times, const std::vector<UsdValue>& values) {
  const uint64_t times_place = align();
  put(static_cast<uint64_t>(times.size()));
  for (const double time : times) put(time);
  // Both parts may lie elsewhere: each begins with the way to it.
  const uint64_t place = align();
  put(int64_t{8});
  put(value_at(UsdType::double_vector, times_place));
  put(int64_t{8});
  put(static_cast<uint64_t>(values.size()));
  for (const UsdValue value : values) put(value);
  return value_at(UsdType::time_samples, place);
}

void UsdCrate::set_metadata(const std::string& name, UsdValue value) {
  nodes_[0].fields.emplace_back(name, value);
}

std::string UsdCrate::add_prim(const std::string& parent, const std::string& name, const std::string& type) {
  Node node;
  node.name = name;
  node.type = type;
  node.is_prim = true;
  node.fields = {{"specifier", value_at(UsdType::specifier, 0, kInlined)}, {"typeName", token(type)}};
  nodes_.at(paths_.at(parent)).children.push_back(nodes_.size());
  paths_[parent + "/" + name] = nodes_.size();
  nodes_.push_back(std::move(node));
  return parent + "/" + name;
}

void UsdCrate::add_attribute(const std::string& prim, const std::string& name, const std::string& type, bool uniform,
                             const std::string& field, UsdValue value) {
  Node node;
  node.name = name;
  node.fields = {{"typeName", token(type)}};
  if (uniform) node.fields.emplace_back("variability", value_at(UsdType::variability, 1, kInlined));
  node.fields.emplace_back(field, value);
  nodes_.at(paths_.at(prim)).attributes.push_back(nodes_.size());
  nodes_.push_back(std::move(node));
}

std::vector<size_t> UsdCrate::below(size_t node) const {
  std::vector<size_t> all = nodes_[node].attributes;
  all.insert(all.end(), nodes_[node].children.begin(), nodes_[node].children.end());
  return all;
}

// Depth first. Names of attributes are negative.
void UsdCrate::add_paths(const std::vector<size_t>& siblings, Tree& tree) {
  for (size_t k = 0; k < siblings.size(); ++k) {
    const Node& node = nodes_[siblings[k]];
    const std::vector<size_t> inside = below(siblings[k]);
    const bool more = k + 1 < siblings.size();
    const size_t place = tree.nodes.size();
    const auto name = static_cast<int32_t>(token_index(node.name));
    tree.nodes.push_back(static_cast<int32_t>(siblings[k]));
    tree.names.push_back(node.is_prim ? name : -name);
    tree.jumps.push_back(!inside.empty() ? kChild : more ? kSibling : kNothing);
    add_paths(inside, tree);
    if (!inside.empty() && more) tree.jumps[place] = static_cast<int32_t>(tree.nodes.size() - place);
  }
}

void UsdCrate::write_packed(const std::string& bytes) {
  const std::string packed = literals(bytes);
  put(static_cast<uint64_t>(packed.size()));
  file_.write(packed);
}

void UsdCrate::write_numbers(const std::vector<int32_t>& numbers) {
  write_packed(differences(numbers));
}

bool UsdCrate::commit() {
  // What lies below each prim, in the words of the format.
  for (size_t i = 0; i < nodes_.size(); ++i) {
    std::vector<std::string> prims, attributes;
    for (const size_t child : nodes_[i].children) prims.push_back(nodes_[child].name);
    for (const size_t child : nodes_[i].attributes) attributes.push_back(nodes_[child].name);
    if (!prims.empty()) nodes_[i].fields.emplace_back("primChildren", tokens(prims));
    if (!attributes.empty()) nodes_[i].fields.emplace_back("properties", tokens(attributes));
  }
  struct Section {
    const char* name;
    uint64_t start, size;
  };
  std::vector<Section> sections;
  const auto section = [&](const char* name, const auto& write) {
    const uint64_t start = align();
    write();
    sections.push_back({name, start, file_.written() - start});
  };
  // The other sections name no tokens that are not known by then.
  for (const Node& node : nodes_) {
    token_index(node.name);
    for (const auto& [name, value] : node.fields) token_index(name);
  }
  section("TOKENS", [&] {
    std::string text;
    for (const std::string& t : tokens_) text += t + '\0';
    put(static_cast<uint64_t>(tokens_.size()));
    put(static_cast<uint64_t>(text.size()));
    write_packed(text);
  });
  section("STRINGS", [&] {
    put(static_cast<uint64_t>(strings_.size()));
    for (const uint32_t index : strings_) put(index);
  });
  std::vector<int32_t> fields, sets, first_field;  // first_field: of each node, in `sets`
  std::string values;
  for (const Node& node : nodes_) {
    first_field.push_back(static_cast<int32_t>(sets.size()));
    for (const auto& [name, value] : node.fields) {
      sets.push_back(static_cast<int32_t>(fields.size()));
      fields.push_back(static_cast<int32_t>(token_index(name)));
      values.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
    sets.push_back(-1);
  }
  section("FIELDS", [&] {
    put(static_cast<uint64_t>(fields.size()));
    write_numbers(fields);
    write_packed(values);
  });
  section("FIELDSETS", [&] {
    put(static_cast<uint64_t>(sets.size()));
    write_numbers(sets);
  });
  section("PATHS", [&] {
    Tree tree;
    add_paths({0}, tree);
    put(static_cast<uint64_t>(nodes_.size()));
    put(static_cast<uint64_t>(tree.nodes.size()));
    for (const std::vector<int32_t>* numbers : {&tree.nodes, &tree.names, &tree.jumps}) write_numbers(*numbers);
  });
  section("SPECS", [&] {
    std::vector<int32_t> paths, kinds;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      paths.push_back(static_cast<int32_t>(i));
      kinds.push_back(i == 0 ? kRoot : nodes_[i].is_prim ? kPrim : kAttribute);
    }
    put(static_cast<uint64_t>(nodes_.size()));
    for (const std::vector<int32_t>* numbers : {&paths, &first_field, &kinds}) write_numbers(*numbers);
  });
  const uint64_t table = align();
  put(static_cast<uint64_t>(sections.size()));
  for (const Section& s : sections) {
    std::array<char, 16> name = {};
    std::memcpy(name.data(), s.name, std::strlen(s.name));
    put(name);
    put(s.start);
    put(s.size);
  }
  std::array<char, 24> head = {'P', 'X', 'R', '-', 'U', 'S', 'D', 'C', 0, 8, 0};
  std::memcpy(&head[16], &table, sizeof(table));
  file_.overwrite(0, head.data(), head.size());
  return file_.commit();
}

}  // namespace physmas::splat
