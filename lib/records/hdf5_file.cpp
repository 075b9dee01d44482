#include "records/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <set>
#include <type_traits>

#include "base/error.h"
#include "records/hdf5_check.h"
#include "records/hdf5_handle.h"
#include "records/hdf5_text.h"
#include "records/json.h"

namespace physmas {
namespace {

constexpr uint64_t kAny = UINT64_MAX;

template <class T>
hid_t native_type() {
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, uint8_t>) return H5T_NATIVE_UINT8;
}

template <class T>
hid_t file_type() {
  if constexpr (std::is_same_v<T, float>) return H5T_IEEE_F32LE;
  if constexpr (std::is_same_v<T, double>) return H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<T, int32_t>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<T, uint8_t>) return H5T_STD_U8LE;
}

template <class T>
const char* type_name() {
  if constexpr (std::is_same_v<T, float>) return "float32";
  if constexpr (std::is_same_v<T, int32_t>) return "int32";
  return "uint8";
}

std::vector<uint64_t> shape_of(hid_t dataset) {
  const Handle space(must(H5Dget_space(dataset)));
  const int rank = must(H5Sget_simple_extent_ndims(space));
  std::vector<hsize_t> dims(rank);
  if (rank > 0) must(H5Sget_simple_extent_dims(space, dims.data(), nullptr));
  return {dims.begin(), dims.end()};
}

std::string extents_text(const std::vector<uint64_t>& shape) {
  std::vector<std::string> parts;
  for (uint64_t n : shape) parts.push_back(n == kAny ? "*" : std::to_string(n));
  return fmt::format("[{}]", fmt::join(parts, ", "));
}

template <class T>
bool matches_type(hid_t dataset) {
  const Handle type(H5Dget_type(dataset));
  return H5Tequal(type, file_type<T>()) > 0 || H5Tequal(type, native_type<T>()) > 0;
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string& path, const std::string& record) : path_(path), record_(record) {
  check_hdf5(path, record);
  file_ = open_hdf5(path.c_str());
  if (file_ < 0) throw system_error(path, "cannot be opened again", errno);
  try {
    const std::string schema = read_text_attribute("/", "schema");
    const std::string expected = "physmas/" + record + "/1";
    if (schema != expected) throw invalid("/@schema", "\"" + schema + "\"", "\"" + expected + "\"");
  } catch (...) {
    H5Fclose(file_);
    throw;
  }
}

Hdf5Reader::Hdf5Reader(const std::string& path, int64_t file) : path_(path), file_(file) {
  H5Iinc_ref(file_);
}

Hdf5Reader::~Hdf5Reader() {
  H5Fclose(file_);
}

Error Hdf5Reader::invalid(const std::string& where, const std::string& found, const std::string& expected) const {
  return invalid_input({path_, where, found, expected});
}

bool Hdf5Reader::exists(const std::string& name) const {
  const auto is_there = [&](const std::string& path) {
    const htri_t there = H5Lexists(file_, path.c_str(), H5P_DEFAULT);
    // Not "no": a mask that cannot be looked for is not one that is not there.
    if (there < 0) throw invalid(path, "a link that cannot be read", "a group or dataset, or nothing");
    return there > 0;
  };
  // H5Lexists wants every group on the way to exist.
  for (size_t slash = name.find('/', 1); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    if (!is_there(name.substr(0, slash))) return false;
  }
  return is_there(name);
}

std::vector<std::string> Hdf5Reader::names_in(const std::string& group) const {
  std::vector<std::string> names;
  const Handle g(H5Gopen2(file_, group.c_str(), H5P_DEFAULT));
  if (!g.ok()) throw invalid(group, "nothing", "a group");
  H5G_info_t info;
  if (H5Gget_info(g, &info) < 0) throw invalid(group, "an unreadable group", "a group");
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t size = H5Lget_name_by_idx(g, ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT);
    if (size < 0) throw invalid(group, "an unreadable link", "a group");
    std::string name(static_cast<size_t>(size) + 1, '\0');
    must(H5Lget_name_by_idx(g, ".", H5_INDEX_NAME, H5_ITER_INC, i, &name[0], name.size(), H5P_DEFAULT));
    name.resize(static_cast<size_t>(size));
    names.push_back(name);
  }
  return names;
}

void Hdf5Reader::add_datasets(const std::string& group, std::vector<std::string>& names) const {
  for (const std::string& name : names_in(group)) {
    const std::string path = (group == "/" ? "" : group) + "/" + name;
    const Handle object(H5Oopen(file_, path.c_str(), H5P_DEFAULT));
    if (H5Iget_type(must<hid_t>(object)) == H5I_GROUP) {
      add_datasets(path, names);
    } else {
      names.push_back(path);
    }
  }
}

void Hdf5Reader::allow_only(const std::vector<std::string>& datasets) const {
  std::vector<std::string> there;
  add_datasets("/", there);
  const std::set<std::string> known(datasets.begin(), datasets.end());
  for (const std::string& name : there) {
    if (known.count(name) > 0) continue;
    throw invalid(name, "an unknown dataset", "the datasets of schemas/" + record_ + ".h5.md only");
  }
}

std::vector<uint64_t> Hdf5Reader::shape(const std::string& dataset) const {
  const Handle d(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT));
  if (!d.ok()) throw invalid(dataset, "nothing", "a dataset");
  return shape_of(d);
}

template <class T>
std::vector<T> Hdf5Reader::read(const std::string& name, const std::vector<uint64_t>& expected, uint64_t limit) const {
  const std::string wanted = fmt::format("{} of shape {}", type_name<T>(), extents_text(expected));
  const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT));
  if (!dataset.ok()) throw invalid(name, "nothing", wanted);
  if (!matches_type<T>(dataset)) throw invalid(name, "another element type", wanted);
  const std::vector<uint64_t> shape = shape_of(dataset);
  bool fits = shape.size() == expected.size();
  uint64_t count = 1;
  for (size_t i = 0; fits && i < shape.size(); ++i) {
    fits = expected[i] == kAny || expected[i] == shape[i];
    if (shape[i] != 0 && count > limit / shape[i])
      throw invalid(name, "shape " + extents_text(shape), fmt::format("at most {} elements", limit));
    count *= shape[i];
  }
  if (!fits) throw invalid(name, "shape " + extents_text(shape), "shape " + extents_text(expected));
  std::vector<T> values(count);
  if (count > 0 && H5Dread(dataset, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    throw invalid(name, "data that cannot be read (cut short or corrupt)", wanted);
  }
  if constexpr (std::is_same_v<T, float>) {
    for (size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i]))
        throw invalid(name, fmt::format("{} at element {}", values[i], i), "finite numbers");
    }
  }
  return values;
}

std::vector<float> Hdf5Reader::read_float(const std::string& d, const std::vector<uint64_t>& e, uint64_t limit) const {
  return read<float>(d, e, limit);
}
std::vector<int32_t> Hdf5Reader::read_int(const std::string& d, const std::vector<uint64_t>& e, uint64_t limit) const {
  return read<int32_t>(d, e, limit);
}
std::vector<uint8_t> Hdf5Reader::read_byte(const std::string& d, const std::vector<uint64_t>& e, uint64_t limit) const {
  return read<uint8_t>(d, e, limit);
}

std::vector<float> Hdf5Reader::read_float_slab(const std::string& name, uint64_t index, uint64_t count) const {
  const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT));
  if (!dataset.ok()) throw invalid(name, "nothing", "a float32 dataset");
  const std::vector<uint64_t> shape = shape_of(dataset);
  if (shape.empty() || !matches_type<float>(dataset))
    throw invalid(name, "shape " + extents_text(shape), "a float32 dataset");
  if (index > shape[0] || count > shape[0] - index)
    throw invalid(name, "shape " + extents_text(shape), fmt::format("rows up to {}", index + count));
  uint64_t elements = count;
  for (size_t i = 1; i < shape.size(); ++i) {
    if (shape[i] != 0 && elements > (uint64_t{1} << 31) / shape[i])
      throw invalid(name, "shape " + extents_text(shape), "at most 2^31 elements");
    elements *= shape[i];
  }
  std::vector<hsize_t> offset(shape.size(), 0), extent(shape.begin(), shape.end());
  offset[0] = index;
  extent[0] = count;
  const Handle space(must(H5Dget_space(dataset)));
  must(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, extent.data(), nullptr));
  const Handle memory(must(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr)));
  std::vector<float> values(elements);
  if (elements > 0 && H5Dread(dataset, H5T_NATIVE_FLOAT, memory, space, H5P_DEFAULT, values.data()) < 0) {
    throw invalid(name, "data that cannot be read (cut short or corrupt)", "a float32 dataset");
  }
  return values;
}

std::vector<double> Hdf5Reader::read_attribute(const std::string& object, const std::string& name, size_t count) const {
  const std::string where = (object == "/" ? "" : object) + "/@" + name;
  const std::string wanted = fmt::format("{} numbers", count);
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
  if (!attribute.ok()) throw invalid(where, "nothing", wanted);
  const Handle space(H5Aget_space(attribute));
  if (H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(count)) {
    throw invalid(where, fmt::format("{} numbers", H5Sget_simple_extent_npoints(space)), wanted);
  }
  std::vector<double> values(count);
  if (H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()) < 0) throw invalid(where, "another type", wanted);
  for (double v : values) {
    if (!std::isfinite(v)) throw invalid(where, fmt::format("{}", v), "finite numbers");
  }
  return values;
}

std::string Hdf5Reader::read_text_attribute(const std::string& object, const std::string& name) const {
  const std::string where = (object == "/" ? "" : object) + "/@" + name;
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
  if (!attribute.ok()) throw invalid(where, "nothing", "text");
  const Handle type(H5Aget_type(attribute));
  if (H5Tget_class(type) != H5T_STRING) throw invalid(where, "another type", "text");
  const Handle space(H5Aget_space(attribute));
  const hssize_t texts = H5Sget_simple_extent_npoints(space);
  if (texts != 1) throw invalid(where, fmt::format("{} texts", texts), "one text");
  if (H5Tis_variable_str(type) > 0) return read_variable_text(attribute, path_, where);
  const size_t size = H5Tget_size(type);
  if (size > kMaxHdf5Text) throw invalid(where, fmt::format("{} bytes", size), "a shorter text");
  std::string text(size, '\0');
  if (H5Aread(attribute, type, &text[0]) < 0) throw invalid(where, "text that cannot be read", "text");
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

Hdf5Writer::Hdf5Writer(const std::string& path, const std::string& record, const Provenance& provenance)
    : path_(path), record_(record), out_(path) {
  prepare_hdf5();
  // Closing the file closes all that is in it: else what a failed close left open would keep the file from being
  // written.
  const Handle access(must(H5Pcreate(H5P_FILE_ACCESS)));
  must(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
  must(H5Pset_file_locking(access, false, true));
  file_ = H5Fcreate(out_.temporary_path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file_ < 0) fail("/");
  write_text_attribute("/", "schema", "physmas/" + record + "/1");
  write_text_attribute("/", "provenance", compact_text(to_json(provenance, folder_of(path))));
}

Hdf5Writer::~Hdf5Writer() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::fail(const std::string& where) const {
  throw Error(ExitCode::invalid_input, path_ + ": cannot be written (" + where + "): is the disk full, or memory?");
}

namespace {

hid_t link_properties() {
  const hid_t properties = must(H5Pcreate(H5P_LINK_CREATE));
  must(H5Pset_create_intermediate_group(properties, 1));
  return properties;
}

hid_t dataset_properties(const std::vector<hsize_t>& chunk, bool compress) {
  const hid_t properties = must(H5Pcreate(H5P_DATASET_CREATE));
  must(H5Pset_obj_track_times(properties, false));
  if (!chunk.empty()) {
    must(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()));
    if (compress) {
      must(H5Pset_shuffle(properties));
      must(H5Pset_deflate(properties, 1));
    }
  }
  return properties;
}

}  // namespace

template <class T>
void Hdf5Writer::write(const std::string& name, const std::vector<uint64_t>& shape, const T* data, bool compress) {
  const std::vector<hsize_t> dims(shape.begin(), shape.end());
  hsize_t count = 1;
  for (hsize_t n : dims) count *= n;
  const bool chunked = compress && count >= 1024;
  const Handle links(link_properties());
  const Handle properties(dataset_properties(chunked ? dims : std::vector<hsize_t>(), chunked));
  const Handle space(must(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr)));
  Handle dataset(H5Dcreate2(file_, name.c_str(), file_type<T>(), space, links, properties, H5P_DEFAULT));
  if (!dataset.ok() || (count > 0 && H5Dwrite(dataset, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) ||
      !dataset.close())
    fail(name);
  note(name, data, count * sizeof(T));
}

void Hdf5Writer::write_float(const std::string& d, const std::vector<uint64_t>& s, const float* data, bool c) {
  write(d, s, data, c);
}
void Hdf5Writer::write_int(const std::string& d, const std::vector<uint64_t>& s, const int32_t* data, bool c) {
  write(d, s, data, c);
}
void Hdf5Writer::write_byte(const std::string& d, const std::vector<uint64_t>& s, const uint8_t* data, bool c) {
  write(d, s, data, c);
}

void Hdf5Writer::create_series(const std::string& name, const std::vector<uint64_t>& slab_shape) {
  std::vector<hsize_t> dims = {0}, limit = {H5S_UNLIMITED}, chunk = {1};
  for (uint64_t n : slab_shape) {
    dims.push_back(n);
    limit.push_back(n);
    chunk.push_back(std::max<hsize_t>(n, 1));
  }
  const Handle links(link_properties());
  const Handle properties(dataset_properties(chunk, true));
  const Handle space(must(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), limit.data())));
  Handle dataset(H5Dcreate2(file_, name.c_str(), H5T_IEEE_F32LE, space, links, properties, H5P_DEFAULT));
  if (!dataset.ok() || !dataset.close()) fail(name);
  note(name, nullptr, 0);
}

void Hdf5Writer::append_slab(const std::string& name, const float* data) {
  Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT));
  if (!dataset.ok()) fail(name);
  std::vector<uint64_t> shape = shape_of(dataset);
  std::vector<hsize_t> extent(shape.begin(), shape.end()), offset(shape.size(), 0), slab(shape.begin(), shape.end());
  offset[0] = shape[0];
  slab[0] = 1;
  ++extent[0];
  if (H5Dset_extent(dataset, extent.data()) < 0) fail(name);
  const Handle space(must(H5Dget_space(dataset)));
  must(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, slab.data(), nullptr));
  const Handle memory(must(H5Screate_simple(static_cast<int>(slab.size()), slab.data(), nullptr)));
  if (H5Dwrite(dataset, H5T_NATIVE_FLOAT, memory, space, H5P_DEFAULT, data) < 0 || !dataset.close()) fail(name);
  hsize_t count = 1;
  for (const hsize_t n : slab) count *= n;
  note(name, data, count * sizeof(float));
}

void Hdf5Writer::make_group(const std::string& group) {
  if (H5Lexists(file_, group.c_str(), H5P_DEFAULT) > 0) return;
  const Handle links(link_properties());
  // Groups must not carry the time of their creation.
  const Handle properties(must(H5Pcreate(H5P_GROUP_CREATE)));
  must(H5Pset_obj_track_times(properties, false));
  Handle g(H5Gcreate2(file_, group.c_str(), links, properties, H5P_DEFAULT));
  if (!g.ok() || !g.close()) fail(group);
}

void Hdf5Writer::write_attribute(const std::string& object, const std::string& name,
                                 const std::vector<double>& values) {
  const hsize_t count = values.size();
  const Handle space(count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr));
  Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT,
                                     H5P_DEFAULT, H5P_DEFAULT));
  if (!attribute.ok() || H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data()) < 0 || !attribute.close())
    fail(object + "/@" + name);
  attributes_.push_back({object, name, values, ""});
}

void Hdf5Writer::write_text_attribute(const std::string& object, const std::string& name, const std::string& text) {
  const Handle type(must(H5Tcopy(H5T_C_S1)));
  must(H5Tset_size(type, text.size() + 1));
  must(H5Tset_cset(type, H5T_CSET_UTF8));
  const Handle space(must(H5Screate(H5S_SCALAR)));
  Handle attribute(
      H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (!attribute.ok() || H5Awrite(attribute, type, text.c_str()) < 0 || !attribute.close()) fail(object + "/@" + name);
  attributes_.push_back({object, name, {}, text});
}

void Hdf5Writer::note(const std::string& dataset, const void* data, size_t size) {
  Sum& sum = sums_[dataset];
  sum.bytes += size;
  if (size > 0) sum.crc = static_cast<uint32_t>(crc32_z(sum.crc, static_cast<const Bytef*>(data), size));
}

namespace {

// Whether every chunk of a dataset of ours went through its filters. Those that cannot get memory are left out, and the
// same data would have other bytes. Chunks reach over all of a dataset but its first axis.
bool is_packed(hid_t file, const std::string& name) {
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT)), properties(H5Dget_create_plist(dataset));
  if (H5Pget_layout(properties) != H5D_CHUNKED) return true;
  const std::vector<uint64_t> shape = shape_of(dataset);
  std::vector<hsize_t> chunk(shape.size()), offset(shape.size(), 0);
  if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) < 0 || chunk[0] == 0) return false;
  for (offset[0] = 0; offset[0] < shape[0]; offset[0] += chunk[0]) {
    unsigned left_out = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    if (H5Dget_chunk_info_by_coord(dataset, offset.data(), &left_out, &address, &bytes) < 0 || left_out != 0)
      return false;
  }
  return true;
}

}  // namespace

// The library may swallow what the system says (version 1.10 does), so the file is compared with what it was given.
void Hdf5Writer::compare(int64_t file) const {
  std::map<std::string, Sum> there;
  walk_hdf5(file, path_, [&](const std::string& dataset, const void* bytes, size_t size) {
    Sum& sum = there[dataset];
    sum.bytes += size;
    sum.crc = static_cast<uint32_t>(crc32_z(sum.crc, static_cast<const Bytef*>(bytes), size));
  });
  const Hdf5Reader reader(path_, file);
  for (const auto& [name, sum] : sums_) {
    if (!reader.exists(name)) fail(name);
    if (!is_packed(file, name)) fail(name);
    const auto found = there.find(name);
    const Sum read = found == there.end() ? Sum() : found->second;
    if (read.bytes != sum.bytes || read.crc != sum.crc) fail(name);
  }
  for (const Attribute& a : attributes_) {
    const bool same = a.values.empty() ? reader.read_text_attribute(a.object, a.name) == a.text
                                       : reader.read_attribute(a.object, a.name, a.values.size()) == a.values;
    if (!same) fail(a.object + "/@" + a.name);
  }
}

bool Hdf5Writer::commit() {
  const herr_t closed = H5Fclose(file_);
  file_ = -1;
  if (closed < 0) fail("/");
  try {
    inspect_hdf5(out_.temporary_path(), record_, [this](hid_t file) { compare(file); });
  } catch (const Error&) {
    fail("what it holds is not what was written");
  }
  return out_.commit();
}

}  // namespace physmas
