// HDF5 artifacts: deterministic bytes, round trips, hostile files.
#include <doctest/doctest.h>
#include <hdf5.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "base/file.h"
#include "records/hdf5_file.h"
#include "records/masks.h"
#include "records/material_field.h"
#include "records/rollout.h"
#include "records/state.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

Provenance test_provenance() {
  Provenance provenance;
  provenance.tool = "test";
  return provenance;
}

State small_state() {
  State state;
  state.row_keys = {"cake/plate", "cake/sponge"};
  for (int i = 0; i < 5; ++i) {
    state.position.push_back(Eigen::Vector3f(0.5f + 0.1f * i, 1, 1));
    state.volume.push_back(1e-6f);
    state.row.push_back(i % 2);
    state.object.push_back(0);
    state.source.push_back(i < 3 ? i : 0);
  }
  state.row[3] = state.row[4] = 0;
  state.gaussian_row = {0, 1, 0};
  state.gaussian_object = {0, 0, 0};
  state.gaussian_confidence = {1, 0.5f, 0.25f};
  state.map.s = 0.25;
  state.map.d = {1, 2, 3};
  return state;
}

// A file with these texts of variable length as attributes of its root.
void write_texts(const std::string& path, const std::vector<std::pair<std::string, std::string>>& texts,
                 hsize_t user_block = 0) {
  const hid_t properties = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_userblock(properties, user_block);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, properties, H5P_DEFAULT);
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  for (const auto& [name, text] : texts) {
    const hid_t attribute = H5Acreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    const char* start = text.c_str();
    CHECK(H5Awrite(attribute, type, &start) >= 0);
    H5Aclose(attribute);
  }
  H5Sclose(space);
  H5Tclose(type);
  H5Fclose(file);
  H5Pclose(properties);
}

std::string little_endian(uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i, value >>= 8) out += static_cast<char>(value & 0xff);
  return out;
}

}  // namespace

TEST_CASE("hdf5: a state survives saving and loading, and equal states give equal bytes") {
  const TemporaryFolder folder;
  save_state(folder / "a.h5", small_state(), test_provenance());
  save_state(folder / "b.h5", small_state(), test_provenance());
  CHECK(read_file(folder / "a.h5") == read_file(folder / "b.h5"));
  const State loaded = load_state(folder / "a.h5");
  CHECK(loaded.gaussian_count() == 3);
  CHECK(loaded.particle_count() == 5);
  CHECK(loaded.position[4] == small_state().position[4]);
  CHECK(loaded.map.d == Eigen::Vector3d(1, 2, 3));
  CHECK(loaded.gaussians_per_row() == std::vector<long>{2, 1});
}

TEST_CASE("hdf5: states with impossible contents are refused") {
  const TemporaryFolder folder;
  const auto error = [&](const std::function<void(State&)>& change) {
    State state = small_state();
    change(state);
    save_state(folder / "s.h5", state, test_provenance());
    return message_of([&] { load_state(folder / "s.h5"); });
  };
  CHECK(error([](State&) {}) == "no error");
  CHECK(error([](State& s) { s.row[4] = -1; }).find("/particles/row: found -1 at element 4") != std::string::npos);
  CHECK(error([](State& s) { s.gaussian_row[0] = 7; }).find("/gaussians/row") != std::string::npos);
  // One behind the last row, object and Gaussian.
  CHECK(error([](State& s) { s.row[4] = 2; }).find("/particles/row: found 2 at element 4") != std::string::npos);
  CHECK(error([](State& s) { s.object[4] = 2; }).find("/particles/object: found 2 at element 4") != std::string::npos);
  CHECK(error([](State& s) { s.source[4] = 3; }).find("/particles/source: found 3 at element 4") != std::string::npos);
  CHECK(error([](State& s) { s.position[3].x() = 2.5f; }).find("/particles/position") != std::string::npos);
  CHECK(error([](State& s) { s.position[3].x() = std::numeric_limits<float>::quiet_NaN(); }).find("finite") !=
        std::string::npos);
  CHECK(error([](State& s) { s.volume[2] = 0; }).find("/particles/volume") != std::string::npos);
  CHECK(error([](State& s) { s.source[1] = 2; }).find("/particles/source") != std::string::npos);
  CHECK(error([](State& s) { s.map.s = 0; }).find("/map/@s") != std::string::npos);
}

TEST_CASE("hdf5: a state with a material field") {
  const TemporaryFolder folder;
  const auto error = [&](const std::function<void(ParticleField&)>& change) {
    State state = small_state();
    state.field = {{1e6f, 0, 2e6f, 0, 3e6f}, {0.25f, 0, 0.5f, 0, 0.125f}, {500, 0, 600, 0, 700}, 0.04};
    change(state.field);
    save_state(folder / "s.h5", state, test_provenance());
    return message_of([&] { load_state(folder / "s.h5"); });
  };
  CHECK(error([](ParticleField&) {}) == "no error");
  const ParticleField loaded = load_state(folder / "s.h5").field;
  CHECK(loaded.E == std::vector<float>{1e6f, 0, 2e6f, 0, 3e6f});
  CHECK(loaded.nu[2] == 0.5f);
  CHECK(loaded.rho[4] == 700);
  CHECK(loaded.reach == 0.04);
  CHECK(error([](ParticleField& f) { f.E[0] = -1; }).find("Young's modulus of -1 Pa at particle 0") !=
        std::string::npos);
  CHECK(error([](ParticleField& f) { f.E[0] = 0; }).find("Young's modulus of 0 Pa at particle 0") != std::string::npos);
  CHECK(error([](ParticleField& f) { f.nu[2] = 0.6f; }).find("Poisson's ratio") != std::string::npos);
  CHECK(error([](ParticleField& f) { f.rho[4] = 1e10f; }).find("density") != std::string::npos);
  CHECK(error([](ParticleField& f) { f.reach = -1; }).find("/field/@reach") != std::string::npos);
}

TEST_CASE("hdf5: a material field survives saving and loading, and hostile ones are refused") {
  const TemporaryFolder folder;
  const auto error = [&](const std::function<void(MaterialField&)>& change) {
    MaterialField field;
    field.position = {{1, 2, 3}, {4, 5, 6}};
    field.E = {1e6f, 2e6f}, field.nu = {0.25f, 0.5f}, field.rho = {500, 600};
    change(field);
    save_material_field(folder / "f.h5", field, test_provenance());
    return message_of([&] { load_material_field(folder / "f.h5"); });
  };
  CHECK(error([](MaterialField&) {}) == "no error");
  const MaterialField loaded = load_material_field(folder / "f.h5");
  CHECK(loaded.position[1] == Eigen::Vector3f(4, 5, 6));
  CHECK(loaded.E == std::vector<float>{1e6f, 2e6f});
  CHECK(loaded.nu == std::vector<float>{0.25f, 0.5f});
  CHECK(loaded.rho == std::vector<float>{500, 600});
  CHECK(error([](MaterialField& f) { f.E[1] = 0; }).find("Young's modulus of 0 Pa in sample 1") != std::string::npos);
  CHECK(error([](MaterialField& f) { f.rho[0] = -5; }).find("density of -5") != std::string::npos);
  CHECK(error([](MaterialField& f) { f.position[0].x() = std::numeric_limits<float>::infinity(); }).find("finite") !=
        std::string::npos);
  save_state(folder / "s.h5", small_state(), test_provenance());
  CHECK(message_of([&] { load_material_field(folder / "s.h5"); }).find("material_field") != std::string::npos);
}

TEST_CASE("hdf5: a state whose carriers move the other Gaussians") {
  const TemporaryFolder folder;
  // Gaussians 1 and 2 are particles, Gaussian 0 follows the latter.
  const auto carried = [] {
    State state = small_state();
    for (auto* list : {&state.row, &state.object, &state.source}) list->erase(list->begin());
    state.position.erase(state.position.begin());
    state.volume.erase(state.volume.begin());
    state.carriers.gaussian = {1, 2};
    state.carriers.rest.assign(3, Eigen::Vector3f(1, 1, 1));
    state.carriers.particle = {1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1};
    state.carriers.weight = {0.5f, 0.25f, 0.25f, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    return state;
  };
  const auto error = [&](const std::function<void(State&)>& change) {
    State state = carried();
    change(state);
    save_state(folder / "s.h5", state, test_provenance());
    return message_of([&] { load_state(folder / "s.h5"); });
  };
  CHECK(error([](State&) {}) == "no error");
  const State loaded = load_state(folder / "s.h5");
  CHECK(loaded.carrier_count() == 2);
  CHECK(loaded.gaussian_count() == 3);
  CHECK(loaded.carriers.gaussian == carried().carriers.gaussian);
  CHECK(loaded.carriers.rest == carried().carriers.rest);
  CHECK(loaded.carriers.particle == carried().carriers.particle);
  CHECK(loaded.carriers.weight == carried().carriers.weight);
  using S = State;
  CHECK(error([](S& s) { s.carriers.gaussian = {2, 1}; }).find("ascending") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.gaussian = {1, 3}; }).find("/carriers/gaussian: found 3") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.gaussian = {0, 1}; }).find("/carriers/particle") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.particle[0] = 2; }).find("/carriers/particle: found 2") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.particle[0] = 0; }).find("of another row for Gaussian 0") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.weight[0] = -0.5f; }).find("/carriers/weight") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.weight[0] = 0.75f; }).find("a sum of 1.25") != std::string::npos);
  CHECK(error([](S& s) { s.carriers.rest[1].y() = 3; }).find("/carriers/rest") != std::string::npos);
  CHECK(error([](S& s) { s.source[0] = 0; }).find("particle 0 that is not Gaussian 1") != std::string::npos);
}

TEST_CASE("hdf5: a state must belong to its inventory") {
  const TemporaryFolder folder;
  save_state(folder / "s.h5", small_state(), test_provenance());
  Inventory inventory;
  inventory.objects = {{"cake", "cake", "", {}, {}}};
  inventory.rows.resize(2);
  inventory.rows[0].object = inventory.rows[1].object = "cake";
  inventory.rows[0].part = "plate";
  inventory.rows[1].part = "icing";
  CHECK(message_of([&] { load_state(folder / "s.h5", &inventory); }).find("rows of the inventory") !=
        std::string::npos);
  inventory.rows[1].part = "sponge";
  CHECK_NOTHROW(load_state(folder / "s.h5", &inventory));
}

TEST_CASE("hdf5: a file cut anywhere is refused, never crashes") {
  const TemporaryFolder folder;
  save_state(folder / "s.h5", small_state(), test_provenance());
  const std::string bytes = read_file(folder / "s.h5");
  for (size_t size = 0; size < bytes.size(); size += 97) {
    CAPTURE(size);
    write_file(folder / "cut.h5", bytes.substr(0, size));
    CHECK(message_of([&] { load_state(folder / "cut.h5"); }) != "no error");
  }
  CHECK(message_of([&] { load_state(folder / "missing.h5"); }) != "no error");
}

TEST_CASE("hdf5: another record, another type, another shape are refused by name") {
  const TemporaryFolder folder;
  save_state(folder / "s.h5", small_state(), test_provenance());
  CHECK(message_of([&] { RolloutReader(folder / "s.h5", 3); }).find("/@schema: found \"physmas/state/1\"") !=
        std::string::npos);
  {
    Hdf5Writer out(folder / "r.h5", "rollout", test_provenance());
    const std::vector<int32_t> ints(6);
    out.write_int("/frames/time", {6}, ints.data());
    out.commit();
  }
  CHECK(message_of([&] { RolloutReader(folder / "r.h5", 3); }).find("/frames/time: found another element type") !=
        std::string::npos);
  {
    RolloutWriter out(folder / "r.h5", 2, "elastic", test_provenance());
    const std::vector<float> x(6, 1), F(18, 0), v(6, 0);
    out.append(0, x.data(), F.data(), v.data());
    out.append(0.04, x.data(), F.data(), v.data());
    out.commit();
  }
  CHECK(message_of([&] { RolloutReader(folder / "r.h5", 3); }).find("/frames/position") != std::string::npos);
  const RolloutReader reader(folder / "r.h5", 2);
  CHECK(reader.frame_count() == 2);
  CHECK(reader.frame(1).position.size() == 6);
}

TEST_CASE("hdf5: an attribute of several texts is refused before it is read") {
  const TemporaryFolder folder;
  const std::string path = folder / "texts.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, 8);
  const hsize_t count = 4;
  const hid_t space = H5Screate_simple(1, &count, nullptr);
  const hid_t attribute = H5Acreate2(file, "schema", type, space, H5P_DEFAULT, H5P_DEFAULT);
  const char texts[4][8] = {"physmas", "physmas", "physmas", "physmas"};
  CHECK(H5Awrite(attribute, type, texts) >= 0);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  H5Fclose(file);
  CHECK(message_of([&] { load_state(path); }).find("/@schema: found 4 texts, expected one text") != std::string::npos);
}

TEST_CASE("hdf5: texts of variable length are read as those of fixed length are") {
  const TemporaryFolder folder;
  const std::string longer(100000, 'x');
  for (const hsize_t user_block : {0, 1024}) {
    const std::string path = folder / "texts.h5";
    write_texts(path, {{"schema", "physmas/state/1"}, {"empty", ""}, {"longer", longer}, {"word", "lollipop"}},
                user_block);
    const Hdf5Reader file(path, "state");
    CHECK(file.read_text_attribute("/", "word") == "lollipop");
    CHECK(file.read_text_attribute("/", "empty").empty());
    CHECK(file.read_text_attribute("/", "longer") == longer);
  }
}

TEST_CASE("hdf5: a text of variable length whose bytes are elsewhere than it says is refused") {
  const TemporaryFolder folder;
  const std::string longer(10000, 'x');
  write_texts(folder / "texts.h5", {{"longer", longer}, {"schema", "physmas/state/1"}});
  const std::string good = read_file(folder / "texts.h5");
  const auto error = [&](size_t at, const std::string& bytes) {
    std::string bad = good;
    write_file(folder / "bad.h5", bad.replace(at, bytes.size(), bytes));
    return message_of([&] { Hdf5Reader(folder / "bad.h5", "state").read_text_attribute("/", "longer"); });
  };
  const size_t data = good.find(longer), object = data - 16, heap = object - 16;
  REQUIRE(data != std::string::npos);
  REQUIRE(good.compare(heap, 4, "GCOL") == 0);
  // Length, address of the heap, number of the object.
  const size_t reference = good.find(little_endian(longer.size(), 4) + little_endian(heap, 8));
  REQUIRE(reference != std::string::npos);
  CHECK(error(0, good.substr(0, 1)) == "no error");
  CHECK(error(reference, little_endian(1, 4)).find("/@longer: found 10000 bytes for a text of 1") != std::string::npos);
  CHECK(error(reference, little_endian(0xffffffff, 4)).find("found 4294967295 bytes, expected a shorter text") !=
        std::string::npos);
  CHECK(error(reference, little_endian(60 << 20, 4)).find("found a heap of") != std::string::npos);
  for (const uint64_t address : {uint64_t{0}, good.size() - 8, uint64_t{1} << 62, ~uint64_t{0}})
    CHECK(error(reference + 4, little_endian(address, 8)).find("without its heap") != std::string::npos);
  CHECK(error(reference + 12, little_endian(7, 4)).find("without the text") != std::string::npos);
  CHECK(error(object + 8, little_endian(~uint64_t{0}, 8)).find("without the text") != std::string::npos);
  for (const uint64_t size : {uint64_t{0}, uint64_t{15}, ~uint64_t{0}})
    CHECK(error(heap + 8, little_endian(size, 8)).find("found a heap of") != std::string::npos);
  CHECK(error(heap + 8, little_endian(60 << 20, 8)).find("cut off") != std::string::npos);
  // No byte that says where the text is does more than be refused.
  for (const size_t start : {reference, heap, object}) {
    for (size_t at = start; at < start + 16; ++at) {
      for (const int flip : {0x01, 0x80, 0xff}) error(at, std::string(1, static_cast<char>(good[at] ^ flip)));
    }
  }
}

TEST_CASE("hdf5: masks name unknown views, objects and rows") {
  const TemporaryFolder folder;
  Inventory inventory;
  inventory.objects = {{"cake", "cake", "", {}, {}}};
  inventory.rows.resize(1);
  inventory.rows[0].object = "cake";
  inventory.rows[0].part = "plate";
  Mask mask;
  mask.width = 4, mask.height = 3;
  mask.pixels.assign(12, 255);
  mask.confidence = 0.75;
  mask.source = "hints";
  save_masks(folder / "m.h5", inventory, {{"front", {mask}, {mask}}, {"back", {Mask()}, {Mask()}}}, {},
             test_provenance());
  const std::vector<ViewMasks> loaded = load_masks(folder / "m.h5", inventory, {"front", "back"});
  CHECK(loaded[0].rows[0].area() == 12);
  CHECK(loaded[0].rows[0].confidence == 0.75);
  CHECK(loaded[1].objects[0].empty());
  CHECK(message_of([&] { load_masks(folder / "m.h5", inventory, {"front"}); }).find("/views/back") !=
        std::string::npos);
  CHECK(message_of([&] {
          load_masks(folder / "m.h5", inventory, {"front", "back", "left"});
        }).find("/views/left") != std::string::npos);
  inventory.rows[0].part = "icing";
  CHECK(message_of([&] {
          load_masks(folder / "m.h5", inventory, {"front", "back"});
        }).find("unknown row key") != std::string::npos);
}

TEST_CASE("hdf5: a file on which the library crashes is refused in one line") {
  const TemporaryFolder folder;
  CHECK(message_of([&] { load_state("tests/data/damaged-state.h5"); }).find("damaged-state.h5: ") != std::string::npos);
}

TEST_CASE("hdf5: data, groups and links stay in the file") {
  const TemporaryFolder folder;
  // A good file to which `add` adds.
  const auto error = [&](const std::function<void(hid_t)>& add) {
    const std::string path = folder / "s.h5";
    save_state(path, small_state(), test_provenance());
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    add(file);
    H5Fclose(file);
    return message_of([&] { load_state(path); });
  };
  CHECK(error([](hid_t) {}) == "no error");
  CHECK(error([](hid_t file) {
          H5Lcreate_soft("/particles/volume", file, "/gaussians/v", H5P_DEFAULT, H5P_DEFAULT);
        }).find("/gaussians/v: found a soft link") != std::string::npos);
  CHECK(error([](hid_t file) {
          H5Lcreate_external("o.h5", "/x", file, "/gaussians/v", H5P_DEFAULT, H5P_DEFAULT);
        }).find("/gaussians/v: found a link to another file") != std::string::npos);
  CHECK(error([](hid_t file) {
          H5Lcreate_hard(file, "/", file, "/gaussians/up", H5P_DEFAULT, H5P_DEFAULT);
        }).find("groups nested deeper") != std::string::npos);
  const auto dataset = [](hid_t file, const char* name, hid_t properties, hid_t type = H5T_IEEE_F32LE) {
    const hsize_t count = 5;
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    H5Dclose(H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Sclose(space);
  };
  CHECK(error([&](hid_t file) {
          const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
          H5Pset_external(properties, "secret.bin", 0, 20);
          H5Ldelete(file, "/particles/volume", H5P_DEFAULT);
          dataset(file, "/particles/volume", properties);
          H5Pclose(properties);
        }).find("/particles/volume: found data in another file") != std::string::npos);
  CHECK(error([&](hid_t file) {
          const hsize_t count = 5;
          const hid_t properties = H5Pcreate(H5P_DATASET_CREATE), space = H5Screate_simple(1, &count, nullptr);
          H5Pset_virtual(properties, space, "other.h5", "/x", space);
          H5Ldelete(file, "/particles/volume", H5P_DEFAULT);
          dataset(file, "/particles/volume", properties);
          H5Sclose(space);
          H5Pclose(properties);
        }).find("/particles/volume: found a virtual dataset") != std::string::npos);
  CHECK(error([&](hid_t file) {
          dataset(file, "/particles/mass", H5P_DEFAULT);
        }).find("/particles/mass: found an unknown dataset") != std::string::npos);
}

TEST_CASE("hdf5: a file is compared with what it was given before it appears") {
  const TemporaryFolder folder;
  const std::vector<float> values(4096, 1.5f);
  const auto written = [&](const std::function<void(const std::string&)>& spoil) {
    return message_of([&] {
      Hdf5Writer out(folder / "r.h5", "rollout", test_provenance());
      out.write_float("/frames/time", {4096}, values.data(), false);
      for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
        if (entry.path().filename().string()[0] == '.') spoil(entry.path());
      }
      out.commit();
    });
  };
  CHECK(written([](const std::string&) {}) == "no error");
  std::filesystem::remove(folder / "r.h5");
  // The data lie in the file already; what is written into it from outside, the library does not see.
  CHECK(written([&](const std::string& half) {
          std::fstream file(half, std::ios::in | std::ios::out | std::ios::binary);
          file.seekp(12000);
          file.write("\xff\xff", 2);
        }).find("is not what was written") != std::string::npos);
  CHECK(std::filesystem::is_empty(folder.path()));
}
