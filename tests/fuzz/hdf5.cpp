// The contents of state.h5, masks.h5, rollouts and material fields: the input says which datasets and attributes an
// HDF5 file has, of what type and shape and with what values. So the fuzzer tests what the readers check, not the HDF5
// library.
//
// Input: the record (0 state, 1 rollout, 2 masks, 3 a wrong schema, 4 a material field), then entries until the end:
//   0 dataset: name, type, rank, extents (255: 2^40 without data), values
//   1 attribute of numbers: object, name, type, count, values
//   2 attribute of text: object (from 128 on the text has variable length), name, length, bytes
// Names, types and objects are numbers into the lists below; what the input lacks is zero.
#include <hdf5.h>

#include <string>
#include <vector>

#include "guard.h"
#include "records/hdf5_check.h"
#include "records/masks.h"
#include "records/material_field.h"
#include "records/rollout.h"
#include "records/state.h"
#include "scratch.h"

namespace {

using namespace physmas;

const std::vector<std::string> kRecords = {"state", "rollout", "masks", "plan", "material_field"};
const std::vector<std::string> kNames = {"/gaussians/row",
                                         "/gaussians/object",
                                         "/gaussians/confidence",
                                         "/particles/row",
                                         "/particles/object",
                                         "/particles/source",
                                         "/particles/volume",
                                         "/particles/position",
                                         "/frames/time",
                                         "/frames/position",
                                         "/frames/F",
                                         "/frames/velocity",
                                         "/views/front/objects/lollipop",
                                         "/views/front/rows/lollipop/candy",
                                         "/views/front/rows/lollipop",
                                         "/views/back/objects/lollipop",
                                         "/views/front/objects/spoon",
                                         "/map",
                                         "/carriers/gaussian",
                                         "/carriers/rest",
                                         "/carriers/particle",
                                         "/carriers/weight",
                                         "/field/youngs_modulus",
                                         "/field/poisson_ratio",
                                         "/field/density",
                                         "/field",
                                         "/samples/position",
                                         "/samples/youngs_modulus",
                                         "/samples/poisson_ratio",
                                         "/samples/density"};
const std::vector<std::string> kAttributes = {"rows", "omitted",    "s",      "d",      "L",
                                              "n",    "confidence", "source", "schema", "reach"};

class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  bool empty() const { return at_ >= size_; }
  uint8_t byte() { return at_ < size_ ? data_[at_++] : 0; }
  const std::string& one_of(const std::vector<std::string>& list) { return list[byte() % list.size()]; }
  std::string bytes(size_t count) {
    const size_t there = std::min(count, size_ - at_);
    std::string bytes(reinterpret_cast<const char*>(data_ + at_), there);
    at_ += there;
    bytes.resize(count);
    return bytes;
  }

 private:
  const uint8_t* data_;
  size_t size_, at_ = 0;
};

hid_t type_of(uint8_t number) {
  const hid_t types[] = {H5T_STD_I32LE,  H5T_IEEE_F32LE, H5T_STD_U8LE, H5T_IEEE_F64LE,
                         H5T_IEEE_F32BE, H5T_STD_I64LE,  H5T_C_S1,     H5T_NATIVE_OPAQUE};
  return types[number % 8];
}

void add_dataset(hid_t file, Input& input, hid_t parents) {
  const std::string name = input.one_of(kNames);
  const hid_t type = type_of(input.byte());
  std::vector<hsize_t> shape(input.byte() % 5);
  hsize_t count = 1;
  bool huge = false;
  for (hsize_t& extent : shape) {
    extent = input.byte();
    huge = huge || extent == 255;
    if (extent == 255) extent = hsize_t{1} << 40;
    count *= huge ? 0 : extent;
  }
  const hid_t space =
      shape.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  const hid_t set = H5Dcreate2(file, name.c_str(), type, space, parents, H5P_DEFAULT, H5P_DEFAULT);
  if (set >= 0 && count > 0 && count < 4096) {
    const std::string values = input.bytes(count * H5Tget_size(type));
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  if (set >= 0) H5Dclose(set);
  H5Sclose(space);
}

void add_attribute(hid_t file, Input& input, bool text) {
  const uint8_t index = input.byte();
  const std::string object = index % 128 == 0 ? "/" : kNames[index % 128 % kNames.size()];
  const std::string name = input.one_of(kAttributes);
  if (object == "/map" && H5Lexists(file, "/map", H5P_DEFAULT) <= 0)
    H5Gclose(H5Gcreate2(file, "/map", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  const hid_t type = H5Tcopy(text ? H5T_C_S1 : type_of(input.byte()));
  const hsize_t count = input.byte();
  const bool variable = text && index >= 128;
  if (text) H5Tset_size(type, variable ? H5T_VARIABLE : count + 1);
  const hid_t space = text ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr);
  const hid_t attribute =
      H5Acreate_by_name(file, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const std::string values = input.bytes(text ? count : count * H5Tget_size(type)) + std::string(8, '\0');
  if (attribute >= 0) {
    const char* start = values.data();
    H5Awrite(attribute, type, variable ? static_cast<const void*>(&start) : start);
    H5Aclose(attribute);
  }
  H5Sclose(space);
  H5Tclose(type);
}

void write_file(const std::string& path, const std::string& record, Input& input) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS), parents = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_fapl_core(access, 1 << 16, 1);
  H5Pset_create_intermediate_group(parents, 1);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const std::string schema = "physmas/" + record + "/1";
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, schema.size() + 1);
  const hid_t attribute = H5Acreate2(file, "schema", type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, type, schema.c_str());
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  for (int entries = 0; entries < 64 && !input.empty(); ++entries) {
    switch (input.byte() % 3) {
      case 0:
        add_dataset(file, input, parents);
        break;
      case 1:
        add_attribute(file, input, false);
        break;
      default:
        add_attribute(file, input, true);
    }
  }
  H5Fclose(file);
  H5Pclose(parents);
  H5Pclose(access);
}

// Of tests/data/tiny.json.
Inventory lollipop() {
  Inventory inventory;
  inventory.objects.emplace_back();
  inventory.objects.back().id = "lollipop";
  for (const char* part : {"stick", "candy"}) {
    inventory.rows.emplace_back();
    inventory.rows.back().object = "lollipop";
    inventory.rows.back().part = part;
  }
  return inventory;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Scratch scratch;
  static const std::string path = scratch / "input.h5";
  static const Inventory inventory = lollipop();
  check_hdf5_in_this_process();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  // The library clears half a megabyte for every file that it opens; so it is kept from one input to the next.
  H5set_free_list_limits(-1, -1, -1, -1, -1, -1);
  Input input(data, size);
  const std::string record = input.one_of(kRecords);
  write_file(path, record, input);
  // What the record does not hold, its schema tells; so one reader each is enough.
  guard([&] {
    if (record == "rollout") {
      const RolloutReader rollout(path, 2);
      for (int t = 0; t < rollout.frame_count(); ++t) rollout.frame(t);
    } else if (record == "masks") {
      load_masks(path, inventory, {"front"});
    } else if (record == "material_field") {
      load_material_field(path);
    } else {
      load_state(path, size % 2 == 0 ? nullptr : &inventory);
    }
  });
  return 0;
}
