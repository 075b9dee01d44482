// Material fields of other programs: npz and USD.
#include "bundle/material_files.h"

#include <doctest/doctest.h>

#include "unit/input_error.h"
#include "unit/metrics/npz_bytes.h"

using namespace physmas;
using namespace physmas::bundle;
using namespace physmas::testing;

namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

// Two samples.
Entries arrays() {
  return {{"positions.npy", npy<float>("<f4", "(2, 3)", {0, 1, 2, 3, 4, 5})},
          {"youngs_modulus.npy", npy<double>("<f8", "(2,)", {1e6, 2e6})},
          {"poisson_ratio.npy", npy<float>("<f4", "(2, 1)", {0.25f, 0.5f})},
          {"density.npy", npy<int32_t>("<i4", "(2,)", {500, 1200})}};
}

std::string with(const std::string& name, const std::string& bytes) {
  Entries entries = arrays();
  for (auto& entry : entries) {
    if (entry.first == name + ".npy") entry.second = bytes;
  }
  return zip(entries, true);
}

const std::string kUsda =
    "#usda 1.0\n(\n  defaultPrim = \"World\"\n  doc = \"\"\"a ] } of no meaning\"\"\"\n  upAxis = \"Y\"\n)\n"
    "def Xform \"World\" (kind = \"component\") # { a comment\n{\n"
    "  def Points \"Cloud\"\n  {\n"
    "    uniform token[] xformOpOrder = []\n"
    "    point3f[] points = [(0, 1, 2), (3, 4, 5)]\n"
    "    float[] primvars:yms = [1000000, 2e6] (\n      interpolation = \"vertex\"\n    )\n"
    "    custom float[] prs = [0.25, 0.5]\n"
    "    float[] primvars:rhos = [500, 1.2e3]\n"
    "    float[] widths.timeSamples = { 0: [1, 2], 1: [3, 4] }\n"
    "    rel material:binding = </World/Looks/Wood>\n"
    "    asset file = @a}b.png@\n"
    "  }\n}\n";

std::string with(const std::string& from, const std::string& to, const std::string& text) {
  std::string changed = text;
  const size_t at = changed.find(from);
  REQUIRE(at != std::string::npos);
  return changed.replace(at, from.size(), to);
}

std::string refusal(const std::string& bytes) {
  return message_of([&] { parse_material_samples(bytes, "f"); });
}

bool refuses(const std::string& bytes, const std::string& because) {
  const std::string message = refusal(bytes);
  const bool said = message.compare(0, 3, "f: ") == 0 && message.find(because) != std::string::npos;
  if (!said) MESSAGE(message);
  return said;
}

void check_two(const MaterialSamples& samples) {
  REQUIRE(samples.position.size() == 2);
  CHECK(samples.position[0] == Eigen::Vector3d(0, 1, 2));
  CHECK(samples.position[1] == Eigen::Vector3d(3, 4, 5));
  CHECK(samples.E == std::vector<double>{1e6, 2e6});
  CHECK(samples.nu == std::vector<double>{0.25, 0.5});
  CHECK(samples.rho == std::vector<double>{500, 1200});
}

}  // namespace

TEST_CASE("material files: npz of any element type, stored and deflated, and USD text say the same") {
  check_two(parse_material_samples(zip(arrays(), false), "f"));
  check_two(parse_material_samples(zip(arrays(), true), "f"));
  check_two(parse_material_samples(kUsda, "f"));
  // Further arrays do not matter.
  Entries more = arrays();
  more.push_back({"segment.npy", "no array at all"});
  check_two(parse_material_samples(zip(more, false), "f"));
}

TEST_CASE("material files: samples are moved and turned as the Gaussians are, the offset in doubles") {
  MaterialSamples samples;
  samples.position = {{431000.125, 5412001, 213}};
  samples.E = {1e6}, samples.nu = {0.3}, samples.rho = {1000};
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const MaterialField field = placed_samples(samples, {431000, 5412000, 213}, turn);
  CHECK(field.position[0] == Eigen::Vector3f(-1, 0.125f, 0));
  CHECK(field.E[0] == 1e6f);
}

TEST_CASE("material files: arrays that lack, have another shape or hold no material are refused by name") {
  for (const char* name : {"positions", "youngs_modulus", "poisson_ratio", "density"}) {
    Entries entries;
    for (const auto& entry : arrays()) {
      if (entry.first != std::string(name) + ".npy") entries.push_back(entry);
    }
    CHECK(refuses(zip(entries, true), std::string(name) + ".npy: found no such entry"));
  }
  CHECK(refuses(with("positions", npy<float>("<f4", "(6,)", {0, 1, 2, 3, 4, 5})), "positions: found shape [6]"));
  CHECK(refuses(with("positions", npy<float>("<f4", "(3, 2)", {0, 1, 2, 3, 4, 5})), "shape [3, 2]"));
  CHECK(refuses(with("positions", npy<float>("<f4", "(0, 3)", {})), "shape [2], expected shape [0]"));
  CHECK(refuses(with("youngs_modulus", npy<float>("<f4", "(3,)", {1, 2, 3})), "one number per position"));
  CHECK(refuses(with("density", npy<float>("<f4", "(1, 2)", {1, 2})), "density: found shape [1, 2]"));
  const float nan = std::nanf("");
  CHECK(refuses(with("positions", npy<float>("<f4", "(2, 3)", {0, 1, 2, nan, 4, 5})), "of sample 1"));
  CHECK(refuses(with("positions", npy<double>("<f8", "(2, 3)", {0, 1, 2, 1e13, 4, 5})), "of sample 1"));
  for (const float bad : {nan, -1.f, 0.f, INFINITY}) {
    CHECK(refuses(with("youngs_modulus", npy<float>("<f4", "(2,)", {1e6f, bad})), "Young's modulus of"));
    CHECK(refuses(with("density", npy<float>("<f4", "(2,)", {bad, 1000})), "kg/m^3 in sample 0"));
  }
  for (const float bad : {nan, -0.1f, 0.51f})
    CHECK(refuses(with("poisson_ratio", npy<float>("<f4", "(2,)", {0.3f, bad})), "Poisson's ratio of"));
  CHECK(refuses(with("density", npy<float>("<f4", "(1152921504606846976,)", {})), "header of an array"));
  CHECK(refuses(with("positions", npy<float>("<f4", "(10000001, 3)", {})), "bytes of data"));
  for (const std::string& whole : {zip(arrays(), false), zip(arrays(), true)}) {
    for (size_t size = 0; size < whole.size(); ++size) CHECK(refusal(whole.substr(0, size)) != "no error");
  }
}

TEST_CASE("material files: USD that is no text, or not the numbers of points, is refused by name") {
  CHECK(refuses("PXR-USDC" + std::string(100, '\0'), "usdcat --flatten in.usdc -o out.usda"));
  CHECK(refuses(zip({{"scene.usdc", "PXR-USDC"}}, false), "a USD package"));
  CHECK(refuses("ply\nformat ascii 1.0", "another kind of file"));
  CHECK(refuses(with("float[] primvars:rhos = [500, 1.2e3]\n", "", kUsda), "/World/Cloud: found no rhos"));
  CHECK(refuses(with("point3f[] points = [(0, 1, 2), (3, 4, 5)]\n", "", kUsda), "/World/Cloud: found no points"));
  CHECK(refuses(with("prs = [0.25, 0.5]", "prs = [0.25, 0.5, 0.3]", kUsda), "/World/Cloud.prs: found 3 values"));
  CHECK(refuses(with("(3, 4, 5)", "(3, 4)", kUsda), "found 5 coordinates"));
  CHECK(refuses(with("2e6", "nan", kUsda), "Young's modulus of nan"));
  CHECK(refuses(with("2e6", "two", kUsda), "a number of /World/Cloud.yms"));
  CHECK(refuses(with("2e6", "2e999", kUsda), "Young's modulus of nan"));
  CHECK(refuses(with("xformOpOrder = []", "xformOpOrder = [\"xformOp:translate\"]", kUsda), "a transform"));
  // What moves a prim from above counts, too, and may stand behind it.
  const size_t last = kUsda.rfind('}');
  CHECK(refuses(kUsda.substr(0, last) + "uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}\n", "a transform"));
  CHECK(refuses("#usda 1.0\ndef Xform \"World\"\n{\n}\n", "no prim with points, yms, prs and rhos"));
  for (size_t size = 0; size < kUsda.size() - 2; ++size) {
    CAPTURE(size);
    CHECK(refusal(kUsda.substr(0, size)) != "no error");
  }
  std::string deep = "#usda 1.0\n";
  for (int k = 0; k < 100000; ++k) deep += "def \"a\" {";
  CHECK(refuses(deep, "expected"));
  for (int k = 0; k < 100000; ++k) deep += "}";
  CHECK(refuses(deep, "at most 128 prims"));
}

TEST_CASE("material files: several prims of a layer, and one number for all points of one") {
  const std::string text =
      "#usda 1.0\n"
      "def Points \"a\" { point3f[] points = [(0, 0, 0), (1, 0, 0)]; float yms = 5; float[] prs = [0.1]; float[] rhos "
      "= [7] }\n"
      "class \"b\" { point3f[] points = [(2, 0, 0)]\n float[] yms = [6]\n float[] prs = [0.2]\n float[] rhos = [8]\n}\n"
      "over \"c\" { variantSet \"v\" = { \"x\" { float[] yms = [1] } }\n point3f[] points = [(9, 9, 9)]\n}\n";
  const MaterialSamples samples = parse_material_samples(text, "f");
  CHECK(samples.E == std::vector<double>{5, 5, 6});
  CHECK(samples.nu == std::vector<double>{0.1, 0.1, 0.2});
  CHECK(samples.rho == std::vector<double>{7, 7, 8});
  CHECK(samples.position[2].x() == 2);
}
