// make_fuzz_seeds DIR: writes small valid inputs for every target of tests/fuzz into DIR/TARGET.
#include <fmt/format.h>

#include <cstdio>
#include <map>

#include "base/file.h"
#include "base/hash.h"
#include "bundle/physgaussian.h"
#include "records/json.h"
#include "records/scene.h"
#include "remote/exchange.h"
#include "scene/camera.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/video.h"
#include "unit/metrics/npz_bytes.h"
#include "unit/scene/sog_files.h"
#include "unit/scene/spz_bytes.h"

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

// field: with the numbers of a material field.
std::string hdf5_state(bool field) {
  const std::vector<int32_t> two = {0, 1}, zero = {0, 0};
  Hdf5Seed seed(0);
  seed.text(0, 0, R"(["lollipop/stick","lollipop/candy"])").text(0, 1, R"([{"what":"a","why":"b"}])");
  seed.dataset(0, Hdf5Seed::kInt, {2}, two).dataset(1, Hdf5Seed::kInt, {2}, zero);
  seed.dataset<float>(2, Hdf5Seed::kFloat, {2}, {0.5f, 1});
  seed.dataset(3, Hdf5Seed::kInt, {2}, two).dataset(4, Hdf5Seed::kInt, {2}, zero).dataset(5, Hdf5Seed::kInt, {2}, two);
  seed.dataset<float>(6, Hdf5Seed::kFloat, {2}, {0.1f, 0.2f});
  seed.dataset<float>(7, Hdf5Seed::kFloat, {2, 3}, {1, 1, 1, 0.5f, 0.5f, 0.5f});
  if (field) {
    seed.dataset<float>(22, Hdf5Seed::kFloat, {2}, {1e6f, 0}).dataset<float>(23, Hdf5Seed::kFloat, {2}, {0.3f, 0});
    seed.dataset<float>(24, Hdf5Seed::kFloat, {2}, {900, 0}).numbers(25, 9, {0.04});
  }
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
    // One source is a text of variable length, one of fixed length.
    seed.numbers(mask, 6, {0.5}).text(static_cast<char>(mask == 12 ? mask + 128 : mask), 7, "file");
  }
  return seed.bytes();
}

std::string hdf5_material_field() {
  Hdf5Seed seed(4);
  seed.dataset<float>(26, Hdf5Seed::kFloat, {2, 3}, {0, 1, 2, 3, 4, 5});
  seed.dataset<float>(27, Hdf5Seed::kFloat, {2}, {1e6f, 2e6f}).dataset<float>(28, Hdf5Seed::kFloat, {2}, {0.3f, 0});
  return seed.dataset<float>(29, Hdf5Seed::kFloat, {2}, {500, 900}).bytes();
}

std::string usda(const char* variable) {
  return fmt::format(
      "#usda 1.0\n(\n  doc = \"\"\"two\nlines\"\"\"\n)\ndef Xform \"a\" (kind = \"group\")\n{{\n  # voxels\n  def "
      "Points \"b\"\n  "
      "{{\n    uniform token[] xformOpOrder = []\n    point3f[] points = [(0, 1, 2), (3, -4, 5e-1)]\n"
      "    float[] {0}yms = [1e6, 2e6] (\n      interpolation = \"vertex\"\n    )\n    float[] {0}prs = [0.3]\n    "
      "float {0}rhos = 900\n"
      "    float[] w.timeSamples = {{ 0: [1], 1: [2] }}\n    rel m = </a/c>\n    asset f = @x.png@\n  }}\n"
      "  variantSet \"v\" = {{\n    \"x\" {{\n    }}\n  }}\n}}\n",
      variable);
}

std::string exchange() {
  remote::ExchangeRecord record;
  record.name = "model_points";
  record.method = "POST";
  record.url = "http://localhost:8080/v2/models/tracker/infer";
  record.request_body = {
      {"inputs", {{{"name", "queries"}, {"shape", {1, 2}}, {"datatype", "FP32"}, {"data", {1.0, 2.0}}}}},
      {"outputs", {{{"name", "tracks"}}, {{"name", "visibility"}}}}};
  record.status = 200;
  record.content_type = "application/json";
  record.body = R"({"outputs":[{"name":"tracks","datatype":"FP32","shape":[1,2],"data":[[0.5,null]]},)"
                R"({"name":"visibility","datatype":"BOOL","shape":[2,1],"data":[true,false]}]})";
  const Json both = {{"request",
                      {{"method", record.method},
                       {"url", record.url},
                       {"body", record.request_body},
                       {"attachments", record.attachments}}},
                     {"response",
                      {{"status", record.status},
                       {"content_type", record.content_type},
                       {"sha256", sha256_text(record.body)},
                       {"body", record.body}}}};
  Json json = both;
  json["schema"] = "physmas/exchange/1";
  json["name"] = record.name;
  json["sha256"] = record.sha256();
  json["runtime"] = Json::object();
  return json.dump();
}

// The scene agent's answer; part: of its only row besides the stick.
std::string scene_answer(const std::string& actions) {
  return R"({"objects":[{"id":"lollipop","name":"lollipop","scene_role":"target"}],"rows":[)"
         R"({"object":"lollipop","part":"stick","name":"stick","structural_role":"support","physics_group":"","expected_labels":["Wood"]},)"
         R"({"object":"lollipop","part":"candy","name":"candy","structural_role":"","physics_group":"","expected_labels":[]}],)"
         R"("actions":)" +
         actions + "}";
}

std::string tensor(const std::string& name, const std::string& type, const std::string& shape,
                   const std::string& data) {
  return R"({"name":")" + name + R"(","datatype":")" + type + R"(","shape":)" + shape + R"(,"data":)" + data + "}";
}

// A reply per string, as tests/fuzz/models.cpp separates them.
std::string answers(char who, const std::vector<std::string>& list) {
  std::string bytes(1, who);
  for (size_t i = 0; i < list.size(); ++i) bytes += (i > 0 ? "\x1e" : "") + list[i];
  return bytes;
}

std::map<std::string, std::string> model_seeds() {
  const std::string press = R"([{"type":"top_press","source":null,"target":"lollipop/candy","role":"target",)"
                            R"("direction":"down","magnitude":0.5,"start":0.1,"end":null}])";
  const std::string drag =
      R"([{"type":"translation","source":"lollipop/candy","target":"the stick","role":"target",)"
      R"("direction":"from the left toward lollipop/stick","magnitude":null,"start":null,"end":1},)"
      R"({"type":"support_hold","source":null,"target":"lollipop","role":"support",)"
      R"("direction":[0,0,1],"magnitude":1,"start":0,"end":1}])";
  const auto query = [](const std::string& key) {
    return R"({"key":")" + key + R"(","text":"a thing","visible_views":["front"],"colors":[[255,0,0]]})";
  };
  const std::string all =
      R"({"queries":[)" + query("lollipop") + "," + query("lollipop/stick") + "," + query("lollipop/candy") + "]}";
  const std::string metadata = R"({"inputs":[{"name":"crops"},{"name":"image"},{"name":"prompt"},{"name":"boxes"}],)"
                               R"("outputs":[{"name":"E_mean"},{"name":"E_uncertainty"},{"name":"nu_mean"},)"
                               R"({"name":"nu_uncertainty"},{"name":"label_evidence"},{"name":"boxes"},)"
                               R"({"name":"scores"},{"name":"phrases"},{"name":"masks"}]})";
  std::string prediction = R"({"outputs":[)";
  for (const char* name : {"E_mean", "E_uncertainty", "nu_mean", "nu_uncertainty"})
    prediction += tensor(name, "FP32", "[1]", "[0.25]") + ",";
  prediction += tensor("label_evidence", "FP32", "[1,14]", "[[0,0,1,null,0,0,0,0,0,0,0,0,0,0]]") + "]}";
  const std::string boxes = R"({"outputs":[)" + tensor("boxes", "FP32", "[2,4]", "[[0,0,4,2],[1,0,8,2]]") + "," +
                            tensor("scores", "FP32", "[2,1]", "[0.9,0.5]") + "," +
                            tensor("phrases", "BYTES", "[2]", R"(["a","b"])") + "]}",
                    masks = R"({"outputs":[)" +
                            tensor("masks", "UINT8", "[2,2,8]",
                                   "[" + std::string("1,0,1,0,1,0,1,0,") +
                                       "1,0,1,0,1,0,1,0,0,0,0,0,0,0,0,0,1,1,1,1,1,1,1,1]") +
                            "," + tensor("scores", "FP32", "[2]", "[0.5,1]") + "]}";
  const Json completion = {{"choices", {{{"finish_reason", "stop"}, {"message", {{"content", scene_answer(press)}}}}}}};
  return {{"scene", answers('s', {"<think>so</think>```json\n" + scene_answer(press) + "```", all})},
          {"scene-again", answers('s', {"no", scene_answer(drag), all})},
          {"scene-registered", answers('r', {scene_answer(drag), R"({"queries":[)" + query("lollipop/stick") + "]}"})},
          {"completion", answers('w', {completion.dump()})},
          {"material",
           answers('m', {R"({"key":"lollipop/stick","abstain":false,"confidence":0.5,"visible_views":["front"],)"
                         R"("labels":[{"label":"Wood","probability":1}],"profiles":[{"profile":"Jelly",)"
                         R"("probability":0.5}],"statistics":{"E":1e9,"nu":null}})"})},
          {"predictor", answers('P', {metadata, prediction, prediction})},
          {"detector", answers('D', {metadata, metadata, boxes, masks})}};
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
  for (int version = 1; version <= 3; ++version) {
    for (int degree = 0; degree <= 1; ++degree) {
      const SpzGaussian g = SpzGaussian::with_degree(degree);
      const std::string body = testing::spz_body(version, degree, {g, g});
      seed(fmt::format("spz/version-{}-degree-{}", version, degree), body);
      if (degree == 1) seed(fmt::format("gaussians/spz-{}", version), testing::gzip(body));
    }
  }
  const SpzGaussian fourth = SpzGaussian::with_degree(1);
  const std::string records("\x03\x00\xbe\xad\x04\x00\x00\x00\x08\x00\x00\x00", 12);  // left-handed
  const std::string spz_body = testing::spz_body(3, 1, {fourth, fourth});
  seed("spz/version-4", testing::spz4(spz_body, 1, records));
  seed("spz/extensions", spz_body + records);
  seed("gaussians/spz-4", testing::spz4(spz_body));
  for (const bool webp : {true, false}) {
    testing::Sog sog(webp);
    seed(fmt::format("gaussians/sog-{}", webp ? "webp" : "png"), sog.archive());
    std::string text = sog.meta.dump(), images;
    for (size_t i = 0; i < sog.images.size(); ++i) {
      text.replace(text.find(sog.images[i].first), sog.images[i].first.size(), std::to_string(i));
      images += "\n--\n" + sog.images[i].second;
    }
    seed(fmt::format("sog/{}", webp ? "webp" : "png"), text + images);
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
  const Json reach = {{"right", 0.5}, {"left", -0.25}, {"down", 0}, {"up", -1}};
  seed("records/cameras", Json({{"schema", "physmas/cameras/1"},
                                {"mode", "fit"},
                                {"distance", 1.25},
                                {"candidates", {"soft"}},
                                {"reach", reach},
                                {"rest", reach},
                                {"cameras", {view["camera"]}},
                                {"omitted", Json::array()}})
                              .dump());
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
  seed("records/configuration",
       R"({"schema":"physmas/configuration/1","settings":["grid.n=32"],"rows":{"lollipop/stick":{"branch":"Metal",)"
       R"("E":1e9,"nu":0.3,"rho":900},"lollipop/candy":{"branch":"Foam","E":1e6,"nu":0.3,"rho":500}},"actions":[]})");
  seed("records/suite",
       R"({"schema":"physmas/suite/1","settings":["grid.n=32"],"methods":[{"id":"physmas","name":"P","settings":[]}],)"
       R"("comparison":["physmas"],"required":["seconds"],"cases":[{"id":"lollipop","kind":"multi-part",)"
       R"("example":"example.json","reference":"reference.json","objects":["lollipop"]}]})");
  seed("records/evaluation",
       R"({"schema":"physmas/evaluation/1","methods":[{"id":"physmas","name":"PhysMAS"},{"id":"other","name":"O"}],)"
       R"("comparison":["physmas","other"],"ablation":["physmas"],"required":["upr"],"cases":[{"id":"cake",)"
       R"("kind":"multi-part","prompt":"it falls","profiles":["Jelly"],"results":{"physmas":{"status":"done",)"
       R"("video":"a.mp4","metrics":["m.json"],"seconds":1},"other":{"status":"failed","reason":"no"}}}]})");

  seed("hdf5/state", hdf5_state(false));
  seed("hdf5/state-field", hdf5_state(true));
  seed("hdf5/material-field", hdf5_material_field());
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

  for (const bool deflate : {false, true}) {
    seed(deflate ? "materials/deflated" : "materials/stored",
         testing::zip({{"positions.npy", testing::npy<float>("<f4", "(2, 3)", {0, 1, 2, 3, 4, 5})},
                       {"youngs_modulus.npy", testing::npy<double>("<f8", "(2,)", {1e6, 2e6})},
                       {"poisson_ratio.npy", testing::npy<float>("<f4", "(2, 1)", {0.3f, 0.4f})},
                       {"density.npy", testing::npy<int32_t>("<i4", "(2,)", {500, 900})}},
                      deflate));
  }
  seed("materials/usda", usda(""));
  seed("materials/usda-primvars", usda("primvars:"));

  for (const int channels : {1, 3, 4}) {
    Image image(5, 4, channels);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<uint8_t>(17 * i);
    seed(fmt::format("images/png-{}", channels), encode_png(image));
  }
  seed("images/png-16-bit", encode_png(3, 2, {0, 1, 256, 1000, 65535, 7}));
  // A grey JPEG of 8 x 8 pixels: one block whose DC difference has no bits.
  seed("images/jpeg", std::string("\xff\xd8\xff\xdb\0\x43\0", 7) + std::string(64, '\1') +
                          std::string("\xff\xc0\0\x0b\x08\0\x08\0\x08\1\1\x11\0", 13) +
                          std::string("\xff\xc4\0\x14\0\1", 6) + std::string(15, '\0') + std::string("\0", 1) +
                          std::string("\xff\xc4\0\x14\x10\1", 6) + std::string(15, '\0') + std::string("\0", 1) +
                          std::string("\xff\xda\0\x08\1\1\0\0\x3f\0\x3f\xff\xd9", 13));

  seed("arrays/embeddings", R"({"text":[1,0],"frames":[[1,0],[0.5,1]]})");

  for (const int frames : {1, 3}) {
    splat::VideoWriter writer(fmt::format("{}/video/{}-frames", folder, frames), 16, 16, 25);
    Image frame(16, 16, 3);
    for (int t = 0; t < frames; ++t) {
      for (size_t i = 0; i < frame.pixels.size(); ++i) frame.pixels[i] = static_cast<uint8_t>((3 + t) * i);
      writer.write(frame);
    }
    writer.finish();
  }

  seed("merges/two", std::string("\x0bit's 1 ball!#version\nb a\nba l\r\nl l</w>\nba ll</w>\n"));
  seed("merges/bytes", std::string("\x02i i\n\xc4\xa0 \xc3\xbf</w>\ni </w>\n"));
  seed("exchange/points", exchange());
  for (const auto& [name, text] : model_seeds()) seed("models/" + name, text);

  const std::string reply = R"({"outputs":[]})", type = "Content-Type: application/json\r\n";
  seed("http/reply", "HTTP/1.1 200 OK\r\n" + type + fmt::format("Content-Length: {}\r\n\r\n{}", reply.size(), reply));
  seed("http/chunked",
       "HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200 OK\r\n" + type +
           fmt::format("Transfer-Encoding: chunked\r\n\r\n{:x}\r\n{}\r\n0\r\n\r\n", reply.size(), reply));
  seed("http/busy", "HTTP/1.1 503 Busy\r\nRetry-After: 1\r\nContent-Type: text/html\r\n\r\n<p>busy");
  seed("http/moved", "HTTP/1.1 307 Moved\r\nLocation: /v1/there\r\nContent-Length: 0\r\n\r\n");
  seed("http/unknown", "HTTP/1.0 404 Not Found\r\n\r\nthe key is key");

  seed("lists/hashes", "h" + std::string(64, 'a') + "  suite.json\n" + std::string(64, '0') + "  cake.json\n");
  seed("lists/result", "rdone\tposterior\t12.5\n");
  seed("lists/failed", "rfailed\tno reason\n");
  seed("lists/log",
       "lpm-lift: info: a\npm-lift: error: b\nmake: *** [x] Error 3\n\x1e"
       "2 1.5\n");

  seed("prompt/press", "A hand presses the top of the sponge of the cake down hard for 0.5 s, then it is released.");
  seed("prompt/roll", "The ball slowly rolls from the left into the cake at 2 m/s after 1 second and bounces off");
  seed("prompt/twist", "twist the icing clockwise; the cake isn't squeezed by the wind, and it falls onto the floor");

  seed("physgaussian/defaults", "{}");
  seed(
      "physgaussian/whole",
      R"({"rotation_degree":[90,180],"rotation_axis":[0,2],"material":"foam","E":2e6,"nu":0.3,"density":200,"n_grid":50,)"
      R"("g":[0,0,-9.8],"sim_area":[-1,1,-1,1,-1,1],"particle_filling":{"max_particles_num":10,"boundary":null},)"
      R"("boundary_conditions":[{"type":"cuboid","point":[1,1,1],"size":[1,1,1],"velocity":[0,0,0]},)"
      R"({"type":"surface_collider","point":[1,1,1],"normal":[0,0,1],"surface":"slip","friction":0.1}],"scale":1.0})");
  return 0;
}
