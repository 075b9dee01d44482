#include "records/hdf5_check.h"

#include <fmt/format.h>
#include <string.h>

#include <algorithm>
#include <vector>

#include "base/apart.h"
#include "base/error.h"
#include "base/file.h"
#include "records/hdf5_handle.h"
#include "records/hdf5_text.h"

namespace physmas {
namespace {

constexpr int kMostObjects = 100000, kMostDepth = 16, kMostAttributes = 1000;
constexpr uint64_t kMostNumbers = uint64_t{1} << 31;     // of a dataset
constexpr uint64_t kMostChunkBytes = uint64_t{1} << 30;  // memory is taken for a whole chunk, and for a row
constexpr uint64_t kMostAttributeNumbers = uint64_t{1} << 20;
constexpr size_t kBlockBytes = size_t{8} << 20;  // of a dataset that is read at once
// Of processor time: for any file, and for each megabyte that it has or unfolds to.
constexpr int kSeconds = 20;
constexpr double kSecondsPerMegabyte = 0.5;

bool g_apart = true;

struct Link {
  std::string name;
  H5L_type_t type;
};

herr_t collect_link(hid_t, const char* name, const H5L_info_t* info, void* links) {
  try {
    static_cast<std::vector<Link>*>(links)->push_back({name, info->type});
    return 0;
  } catch (...) {
    return -1;
  }
}

herr_t collect_name(hid_t, const char* name, const H5A_info_t*, void* names) {
  try {
    static_cast<std::vector<std::string>*>(names)->push_back(name);
    return 0;
  } catch (...) {
    return -1;
  }
}

class Walk {
 public:
  Walk(const std::string& path, const Hdf5Visit& visit) : path_(path), visit_(visit) {}

  void group(hid_t group, const std::string& name, int depth) {
    if (depth > kMostDepth)
      throw error(name, fmt::format("groups nested deeper than {}", kMostDepth), "a shallower file");
    attributes(group, name);
    std::vector<Link> links;
    hsize_t at = 0;
    if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &at, collect_link, &links) < 0)
      throw error(name, "a group that cannot be read (damaged)", "a group");
    for (const Link& link : links) {
      const std::string child = (name == "/" ? "" : name) + "/" + link.name;
      if (++objects_ > kMostObjects) throw error(child, fmt::format("more than {} objects", kMostObjects), "fewer");
      if (link.type != H5L_TYPE_HARD)
        throw error(child, link.type == H5L_TYPE_SOFT ? "a soft link" : "a link to another file", "a hard link",
                    "copy what it leads to into the file");
      object(group, link.name, child, depth);
    }
  }

 private:
  Error error(const std::string& where, const std::string& found, const std::string& expected,
              const std::string& fix = "") const {
    return invalid_input({path_, where, found, expected, fix});
  }

  void object(hid_t parent, const std::string& link, const std::string& name, int depth) {
    Handle object(H5Oopen(parent, link.c_str(), H5P_DEFAULT));
    switch (object.ok() ? H5Iget_type(object) : H5I_BADID) {
      case H5I_GROUP:
        return group(object, name, depth + 1);
      case H5I_DATASET:
        attributes(object, name);
        return dataset(object, name);
      case H5I_DATATYPE:
        throw error(name, "a named type", "groups and datasets only");
      default:
        throw error(name, "an object that cannot be read (damaged)", "a group or a dataset");
    }
  }

  // The data lie in this file, packed as we pack them.
  void check_layout(hid_t dataset, const std::string& name) {
    const Handle properties(H5Dget_create_plist(dataset));
    const H5D_layout_t layout = properties.ok() ? H5Pget_layout(properties) : H5D_LAYOUT_ERROR;
    if (layout == H5D_VIRTUAL) throw error(name, "a virtual dataset", "data in this file", "copy its data into it");
    if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
      throw error(name, "a layout that cannot be read (damaged)", "a contiguous or chunked dataset");
    if (H5Pget_external_count(properties) != 0)
      throw error(name, "data in another file", "data in this file", "copy them into it");
    const int filters = H5Pget_nfilters(properties);
    for (int i = 0; i < filters; ++i) {
      unsigned flags = 0, configuration = 0;
      size_t values = 0;
      const H5Z_filter_t filter =
          H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, &configuration);
      if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32)
        throw error(name, fmt::format("filter {}", static_cast<int>(filter)), "shuffle, deflate and checksums only");
    }
  }

  void dataset(hid_t dataset, const std::string& name) {
    check_layout(dataset, name);
    const Handle type(H5Dget_type(dataset)), space(H5Dget_space(dataset));
    if (!type.ok() || !space.ok()) throw error(name, "a type or shape that cannot be read (damaged)", "a dataset");
    const H5T_class_t type_class = H5Tget_class(type);
    const size_t size = H5Tget_size(type);
    // No numbers of ours, so that no reader asks for them: the reader says so, and which it expects.
    if ((type_class != H5T_INTEGER && type_class != H5T_FLOAT) || size == 0 || size > 8) return;
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 0 || rank > H5S_MAX_RANK) throw error(name, "a shape that cannot be read (damaged)", "a dataset");
    if (rank == 0) return;
    std::vector<hsize_t> shape(static_cast<size_t>(rank));
    must(H5Sget_simple_extent_dims(space, shape.data(), nullptr));
    uint64_t count = 1;
    for (const hsize_t n : shape) {
      if (n != 0 && count > kMostNumbers / n) throw error(name, "more than 2^31 numbers", "at most 2^31 elements");
      count *= n;
    }
    const hsize_t chunk_rows = check_chunk(dataset, name, shape, size);
    if (count == 0) return;
    // In whole chunks along the first axis, each of which is unpacked once.
    const uint64_t row_bytes = count / shape[0] * size;
    if (row_bytes > kMostChunkBytes) throw error(name, "rows of more than 2^30 bytes", "shorter rows");
    const hsize_t step =
        std::max<hsize_t>(chunk_rows, kBlockBytes / std::max<uint64_t>(row_bytes, 1) / chunk_rows * chunk_rows);
    std::vector<char> block(static_cast<size_t>(std::min(step, shape[0]) * row_bytes));
    for (hsize_t row = 0; row < shape[0]; row += step) {
      std::vector<hsize_t> offset(shape.size(), 0), extent = shape;
      offset[0] = row;
      extent[0] = std::min(step, shape[0] - row);
      must(H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, extent.data(), nullptr));
      const Handle memory(must(H5Screate_simple(rank, extent.data(), nullptr)));
      // With the file's own type nothing is converted.
      if (H5Dread(dataset, type, memory, space, H5P_DEFAULT, block.data()) < 0)
        throw error(name, "data that cannot be read (cut short or corrupt)", "a whole dataset");
      if (visit_) visit_(name, block.data(), static_cast<size_t>(extent[0] * row_bytes));
    }
  }

  // Rows of a chunk along the first axis; 1 where there are no chunks.
  hsize_t check_chunk(hid_t dataset, const std::string& name, const std::vector<hsize_t>& shape, size_t size) {
    const Handle properties(H5Dget_create_plist(dataset));
    if (H5Pget_layout(properties) != H5D_CHUNKED) return 1;
    std::vector<hsize_t> chunk(shape.size());
    if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) != static_cast<int>(chunk.size()))
      throw error(name, "chunks that cannot be read (damaged)", "a dataset");
    uint64_t bytes = size;
    for (const hsize_t n : chunk) {
      if (n == 0 || bytes > kMostChunkBytes / n) throw error(name, "chunks of more than 2^30 bytes", "smaller chunks");
      bytes *= n;
    }
    return chunk[0];
  }

  void attributes(hid_t object, const std::string& name) {
    std::vector<std::string> names;
    hsize_t at = 0;
    if (H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, &at, collect_name, &names) < 0)
      throw error(name, "attributes that cannot be read (damaged)", "attributes");
    if (names.size() > kMostAttributes)
      throw error(name, fmt::format("{} attributes", names.size()), fmt::format("at most {}", kMostAttributes));
    for (const std::string& attribute : names) this->attribute(object, attribute, name);
  }

  void attribute(hid_t object, const std::string& name, const std::string& owner) {
    const std::string where = (owner == "/" ? "" : owner) + "/@" + name;
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT));
    if (!attribute.ok()) throw error(where, "an attribute that cannot be read (damaged)", "an attribute");
    const Handle type(H5Aget_type(attribute)), space(H5Aget_space(attribute));
    if (!type.ok() || !space.ok()) throw error(where, "a type or shape that cannot be read (damaged)", "an attribute");
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const size_t size = H5Tget_size(type);
    switch (H5Tget_class(type)) {
      case H5T_STRING:
        // Lists of texts, and texts that are too long, are refused by whoever wants them.
        if (count != 1) return;
        if (H5Tis_variable_str(type) > 0) {
          read_variable_text(attribute, path_, where);
          return;
        }
        if (size > kMaxHdf5Text) return;
        break;
      case H5T_INTEGER:
      case H5T_FLOAT:
        if (count < 0 || static_cast<uint64_t>(count) > kMostAttributeNumbers || size > 8) return;
        break;
      default:
        return;
    }
    std::vector<char> bytes(static_cast<size_t>(count) * size);
    if (!bytes.empty() && H5Aread(attribute, type, bytes.data()) < 0)
      throw error(where, "data that cannot be read (damaged)", "an attribute");
  }

  std::string path_;
  const Hdf5Visit& visit_;
  int objects_ = 0;
};

}  // namespace

void walk_hdf5(hid_t file, const std::string& path, const Hdf5Visit& visit) {
  const Handle root(H5Gopen2(file, "/", H5P_DEFAULT));
  if (!root.ok()) throw invalid_input({path, "/", "a group that cannot be read (damaged)", "a group"});
  Walk(path, visit).group(root, "/", 0);
}

void inspect_hdf5(const std::string& path, const std::string& record, const std::function<void(hid_t)>& look) {
  const std::string expected = "an HDF5 file of record physmas/" + record + "/1";
  const double megabytes = static_cast<double>(regular_file_size(path)) / 1048576;
  const auto open_and_look = [&] {
    const Handle file(open_hdf5(path.c_str()));
    if (!file.ok())
      throw invalid_input({path, "", "a file that HDF5 cannot open (cut short, or another format)", expected});
    look(file);
  };
  prepare_hdf5();
  if (!g_apart) return open_and_look();
  const Ending ending =
      run_apart(open_and_look, kSeconds + static_cast<int>(std::min(megabytes * kSecondsPerMegabyte, 1e6)));
  if (ending.done) return;
  throw invalid_input(
      {path, "",
       ending.too_long ? "data that take too long to read (damaged)"
                       : fmt::format("damaged data, on which the HDF5 library fails ({})", strsignal(ending.signal)),
       expected, "make it again"});
}

void check_hdf5(const std::string& path, const std::string& record) {
  inspect_hdf5(path, record, [&](hid_t file) { walk_hdf5(file, path); });
}

void check_hdf5_in_this_process() {
  g_apart = false;
}

}  // namespace physmas
