// make_fuzz_seeds DIR: writes small valid inputs for every target of tests/fuzz into DIR/TARGET.
#include <fmt/format.h>

#include <cstdio>

#include "../unit/npz_bytes.h"
#include "../unit/spz_bytes.h"
#include "base/file.h"
#include "scene/gaussian_files.h"
#include "scene/physgaussian.h"
#include "scene/scene.h"
#include "splat/image_io.h"

using namespace physmas;

namespace {

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string ply_text(int degree) {
  std::string text = "ply\nformat ascii 1.0\ncomment seed\nelement vertex 2\n";
  const int rest = 3 * (sh_coefficient_count(degree) - 1);
  int columns = 0;
  const auto declare = [&](const std::string& name) { text += "property float " + name + "\n", ++columns; };
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"}) declare(name);
  for (int k = 0; k < rest; ++k) declare(fmt::format("f_rest_{}", k));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    declare(name);
  text += "end_header\n";
  for (int row = 0; row < 2; ++row) {
    for (int k = 0; k < columns; ++k) text += fmt::format("{} ", 0.5 + row - 0.01 * k);
    text += "\n";
  }
  return text;
}

std::string ply_big_endian_with_list() {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uchar short v\nelement vertex 1\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                           "rot_0", "rot_1", "rot_2", "rot_3"}) {
    bytes += std::string("property float ") + name + "\n";
  }
  bytes += "end_header\n";
  bytes += std::string("\2\0\1\0\2", 5);
  for (int k = 0; k < 14; ++k) bytes += std::string("\x3f\x80\0\0", 4);
  return bytes;
}

std::string compressed_ply() {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n";
  for (const char* kind : {"", "scale_"}) {
    for (const char* bound : {"min_", "max_"}) {
      for (const char* axis : {"x", "y", "z"}) bytes += fmt::format("property float {}{}{}\n", bound, kind, axis);
    }
  }
  bytes += "element vertex 2\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    bytes += fmt::format("property uint packed_{}\n", name);
  bytes += "element sh 2\n";
  for (int k = 0; k < 9; ++k) bytes += fmt::format("property uchar f_rest_{}\n", k);
  bytes += "end_header\n";
  for (float v : {-1.f, -1.f, -1.f, 1.f, 1.f, 1.f, -5.f, -5.f, -5.f, 0.f, 0.f, 0.f}) put(bytes, v);
  for (uint32_t v : {0x12345678u, 0xc0ffee11u, 0x01020304u, 0x80a0c0ffu}) put(bytes, v), put(bytes, ~v);
  return bytes + std::string(18, '\x80');
}

std::string splat_file() {
  std::string bytes;
  for (float v : {0.5f, 1.f, -2.f, 0.1f, 0.2f, 0.3f}) put(bytes, v);
  for (uint32_t v : {0xc0804020u, 0x80ff8040u}) put(bytes, v);
  return bytes + bytes;
}

Json pose(double angle) {
  const Camera camera = look_at({5 * std::sin(angle), -5 * std::cos(angle), 1}, {0, 0, 0}, {0, 0, 1}, 1, 64, 48);
  Eigen::Matrix4d m = camera.world_to_camera.inverse();
  m.middleCols<2>(1) *= -1;
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

std::string colmap_text() {
  const std::string cameras = "# cameras\n1 PINHOLE 64 48 60 60 32 24\n2 SIMPLE_RADIAL 64 48 60 32 24 0\n";
  const std::string images = "# images\n1 1 0 0 0 0 0 5 1 a.png\n1 2 -1\n2 0 1 0 0 0 0 5 2 b c.png\n\n";
  return std::string("t") + static_cast<char>(cameras.size()) + '\0' + cameras + images;
}

std::string colmap_binary() {
  std::string cameras, images;
  put<uint64_t>(cameras, 1), put<uint32_t>(cameras, 1), put<int32_t>(cameras, 0);
  put<uint64_t>(cameras, 64), put<uint64_t>(cameras, 48);
  for (double v : {60., 32., 24.}) put(cameras, v);
  put<uint64_t>(images, 1), put<uint32_t>(images, 1);
  for (double v : {1., 0., 0., 0., 0., 0., 5.}) put(images, v);
  put<uint32_t>(images, 1);
  images += std::string("a.png\0", 6);
  put<uint64_t>(images, 1);
  images += std::string(24, 'p');
  return std::string("b") + static_cast<char>(cameras.size()) + '\0' + cameras + images;
}

// Entries as tests/fuzz/hdf5.cpp reads them; datasets, types and attributes by their number there.
class Hdf5Seed {
 public:
  explicit Hdf5Seed(char record) : bytes_(1, record) {}
  enum Type : char { kInt, kFloat, kByte, kDouble };

  template <class T>
  Hdf5Seed& dataset(char name, Type type, const std::vector<int>& shape, const std::vector<T>& values) {
    bytes_ += {0, name, type, static_cast<char>(shape.size())};
    for (const int extent : shape) bytes_ += static_cast<char>(extent);
    for (const T value : values) put(bytes_, value);
    return *this;
  }
  Hdf5Seed& numbers(char object, char name, const std::vector<double>& values) {
    bytes_ += {1, object, name, kDouble, static_cast<char>(values.size())};
    for (const double value : values) put(bytes_, value);
    return *this;
  }
  Hdf5Seed& text(char object, char name, const std::string& text) {
    bytes_ += {2, object, name, static_cast<char>(text.size())};
    bytes_ += text;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string hdf5_state() {
  const std::vector<int32_t> two = {0, 1}, zero = {0, 0};
  Hdf5Seed seed(0);
  seed.text(0, 0, R"(["lollipop/stick","lollipop/candy"])").text(0, 1, R"([{"what":"a","why":"b"}])");
  seed.dataset(0, Hdf5Seed::kInt, {2}, two).dataset(1, Hdf5Seed::kInt, {2}, zero);
  seed.dataset<float>(2, Hdf5Seed::kFloat, {2}, {0.5f, 1});
  seed.dataset(3, Hdf5Seed::kInt, {2}, two).dataset(4, Hdf5Seed::kInt, {2}, zero).dataset(5, Hdf5Seed::kInt, {2}, two);
  seed.dataset<float>(6, Hdf5Seed::kFloat, {2}, {0.1f, 0.2f});
  seed.dataset<float>(7, Hdf5Seed::kFloat, {2, 3}, {1, 1, 1, 0.5f, 0.5f, 0.5f});
  seed.numbers(17, 2, {1}).numbers(17, 3, {0, 0, 0}).numbers(17, 4, {2}).numbers(17, 5, {50});
  return seed.bytes();
}

std::string hdf5_rollout() {
  Hdf5Seed seed(1);
  seed.dataset<float>(8, Hdf5Seed::kFloat, {1}, {0});
  seed.dataset(9, Hdf5Seed::kFloat, {1, 2, 3}, std::vector<float>(6, 1));
  seed.dataset(10, Hdf5Seed::kFloat, {1, 2, 9}, std::vector<float>(18, 1));
  seed.dataset(11, Hdf5Seed::kFloat, {1, 2, 3}, std::vector<float>(6, 0));
  return seed.bytes();
}

std::string hdf5_masks() {
  const std::vector<uint8_t> pixels = {0, 255, 255, 0};
  Hdf5Seed seed(2);
  for (const char mask : {12, 13}) {
    seed.dataset(mask, Hdf5Seed::kByte, {2, 2}, pixels);
    seed.numbers(mask, 6, {0.5}).text(mask, 7, "file");
  }
  return seed.bytes();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "make_fuzz_seeds DIR\n");
    return 2;
  }
  const std::string folder = argv[1];
  const auto seed = [&](const std::string& name, const std::string& bytes) { write_file(folder + "/" + name, bytes); };
  using testing::SpzGaussian;
  for (int degree = 0; degree <= 1; ++degree) seed(fmt::format("gaussians/text-{}", degree), ply_text(degree));
  seed("gaussians/big-endian", ply_big_endian_with_list());
  seed("gaussians/compressed", compressed_ply());
  seed("gaussians/splat", splat_file());
  for (int version = 2; version <= 3; ++version) {
    for (int degree = 0; degree <= 1; ++degree) {
      const SpzGaussian g = SpzGaussian::with_degree(degree);
      const std::string body = testing::spz_body(version, degree, {g, g});
      seed(fmt::format("spz/version-{}-degree-{}", version, degree), body);
      if (degree == 1) seed(fmt::format("gaussians/spz-{}", version), testing::gzip(body));
    }
  }

  Json transforms = {{"w", 64}, {"h", 48}, {"fl_x", 60}, {"k1", 0.1}, {"p2", 0.01}, {"frames", Json::array()}},
       splatting = Json::array();
  Json blender = {{"camera_angle_x", 0.7}, {"frames", Json::array()}};
  for (int i = 0; i < 4; ++i) {
    transforms["frames"].push_back({{"file_path", fmt::format("{}.png", i)}, {"transform_matrix", pose(1.57 * i)}});
    splatting.push_back({{"img_name", "a"},
                         {"width", 64},
                         {"height", 48},
                         {"fx", 60},
                         {"fy", 60},
                         {"position", {0, 0, -5 - i}},
                         {"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}});
  }
  blender["frames"] = transforms["frames"];
  blender["applied_transform"] = {{0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, -1, 0}};
  seed("cameras/transforms", transforms.dump());
  seed("cameras/blender", blender.dump());
  seed("cameras/splatting", splatting.dump());
  seed("cameras/dataparser", R"({"transform":[[1,0,0,0.5],[0,0,1,0],[0,-1,0,2]],"scale":0.4})");
  seed("colmap/text", colmap_text());
  seed("colmap/binary", colmap_binary());

  Json run = to_json(RunSpecification());
  Json view = {
      {"name", "a"}, {"image", "a.png"}, {"camera", to_json(look_at({0, -5, 0}, {0, 0, 0}, {0, 0, 1}, 1, 64, 48))}};
  Json scene = {{"schema", "physmas/scene/1"},
                {"name", "s"},
                {"prompt", "it falls"},
                {"gaussians", "g.ply"},
                {"views", Json::array()},
                {"output_cameras", {view["camera"]}},
                {"run", run}};
  for (const char* name : {"a", "b", "c", "d"}) view["name"] = name, scene["views"].push_back(view);
  seed("records/scene", scene.dump());
  run["schema"] = "physmas/run/1";
  run["colliders"] = {{{"type", "plane"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}},
                      {{"type", "box"}, {"min", {0, 0, 0}}, {"max", {1, 1, 1}}},
                      {{"type", "sphere"}, {"center", {0, 0, 0}}, {"radius", 1}}};
  seed("records/run", run.dump());
  seed(
      "records/inventory",
      R"({"schema":"physmas/inventory/1","objects":[{"id":"a","name":"a","scene_role":"subject"}],"rows":[{"object":"a",)"
      R"("part":"b","name":"b","structural_role":"body","physics_group":"g","expected_labels":["Wood"]}]})");

  seed(
      "records/metrics",
      R"({"schema":"physmas/metrics/1","target":"a","metrics":{"trajectory_nrmse":{"status":"valid","value":0.5,"unit":"",)"
      R"("samples":3},"area_log_rmse":{"status":"invalid","reason":"no mask"}}})");
  const std::string token(64, 'a'), methods = R"("methods":["physmas","other"])";
  seed("records/study", R"({"schema":"physmas/study/1","study":"comparison","token":")" + token + "\"," + methods +
                            R"(,"cases":[{"id":"cake","kind":"multi-part","profiles":["Jelly"],)"
                            R"("codes":{"c1":"physmas","c2":"other"}}]})");
  seed("records/answers", R"({"schema":"physmas/answers/1","token":")" + token +
                              R"(","respondent":"r","answers":[{"case":"cake","order":["c2","c1"],"choice":"c1"}]})");
  seed("records/upr", R"({"schema":"physmas/upr/1","study":"ablation",)" + methods +
                          R"(,"respondents":2,"resamples":10,"seed":0,"cases":[{"id":"cake","responses":2,)"
                          R"("counts":{"physmas":2,"other":0}}],"sets":[{"name":"Jelly","cases":1,"upr":{"physmas":)"
                          R"({"value":100,"low":90,"high":100}}}]})");
  seed("records/evaluation",
       R"({"schema":"physmas/evaluation/1","methods":[{"id":"physmas","name":"PhysMAS"},{"id":"other","name":"O"}],)"
       R"("comparison":["physmas","other"],"ablation":["physmas"],"required":["upr"],"cases":[{"id":"cake",)"
       R"("kind":"multi-part","prompt":"it falls","profiles":["Jelly"],"results":{"physmas":{"status":"done",)"
       R"("video":"a.mp4","metrics":["m.json"],"seconds":1},"other":{"status":"failed","reason":"no"}}}]})");

  seed("hdf5/state", hdf5_state());
  seed("hdf5/rollout", hdf5_rollout());
  seed("hdf5/masks", hdf5_masks());

  seed(
      "coco/runs",
      R"({"images":[{"id":1,"file_name":"a/front.png"},{"id":2,"file_name":"left.jpg"}],"categories":[{"id":3,"name":"candy"}],)"
      R"("annotations":[{"image_id":2,"category_id":3,"score":0.5,"segmentation":{"size":[7,5],"counts":[3,4,28]}},)"
      R"({"image_id":1,"category_id":3,"segmentation":[[1,1,9,1,9,8.5],[2,2,4,2,4,4,2,4]]}]})");
  seed("coco/text",
       R"({"annotations":[{"class_name":"candy","score":[0.9],"segmentation":{"size":[12,16],"counts":"P1`4"}}]})");

  const std::string tracks = testing::npy<float>("<f4", "(1, 2, 3, 2)", {0, 0, 1, 0, 2, 0, 5, 1, 6, 1, 7, 1}),
                    visibility = testing::npy<uint8_t>("|b1", "(1, 2, 3)", {1, 1, 1, 1, 0, 1});
  seed("arrays/float", tracks);
  seed("arrays/bool", visibility);
  for (const bool deflate : {false, true})
    seed(deflate ? "arrays/deflated" : "arrays/stored",
         testing::zip({{"tracks.npy", tracks}, {"visibility.npy", visibility}}, deflate));
  seed("arrays/json", R"({"tracks":[[[0,0],[1,null]]],"visibility":[[1,true]]})");

  for (const int channels : {1, 3, 4}) {
    Image image(5, 4, channels);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<uint8_t>(17 * i);
    seed(fmt::format("images/png-{}", channels), splat::encode_png(image));
  }
  seed("images/png-16-bit", splat::encode_png(3, 2, {0, 1, 256, 1000, 65535, 7}));
  // A grey JPEG of 8 x 8 pixels: one block whose DC difference has no bits.
  seed("images/jpeg", std::string("\xff\xd8\xff\xdb\0\x43\0", 7) + std::string(64, '\1') +
                          std::string("\xff\xc0\0\x0b\x08\0\x08\0\x08\1\1\x11\0", 13) +
                          std::string("\xff\xc4\0\x14\0\1", 6) + std::string(15, '\0') + std::string("\0", 1) +
                          std::string("\xff\xc4\0\x14\x10\1", 6) + std::string(15, '\0') + std::string("\0", 1) +
                          std::string("\xff\xda\0\x08\1\1\0\0\x3f\0\x3f\xff\xd9", 13));

  seed("physgaussian/defaults", "{}");
  seed(
      "physgaussian/whole",
      R"({"rotation_degree":[90,180],"rotation_axis":[0,2],"material":"foam","E":2e6,"nu":0.3,"density":200,"n_grid":50,)"
      R"("g":[0,0,-9.8],"sim_area":[-1,1,-1,1,-1,1],"particle_filling":{"max_particles_num":10,"boundary":null},)"
      R"("boundary_conditions":[{"type":"cuboid","point":[1,1,1],"size":[1,1,1],"velocity":[0,0,0]},)"
      R"({"type":"surface_collider","point":[1,1,1],"normal":[0,0,1],"surface":"slip","friction":0.1}],"scale":1.0})");
  return 0;
}
