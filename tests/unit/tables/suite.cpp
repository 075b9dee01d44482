// The registered benchmark: what is checked, what make is told, and what becomes of results.
#include "tables/suite.h"

#include <doctest/doctest.h>

#include <filesystem>

#include "base/file.h"
#include "candidate/one_material.h"
#include "records/json.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

SuiteCase make_case(const std::string& id, bool multi_object) {
  SuiteCase c;
  c.id = id;
  c.multi_object = multi_object;
  c.prompt = "it falls";
  c.objects = {"a"};
  if (multi_object) c.objects.push_back("b");
  c.profiles = {"Jelly", "Sand"};
  return c;
}

Suite make_suite() {
  Suite suite;
  suite.settings = {"grid.n=32"};
  suite.methods = {{"full", "Full", {}, ""}, {"other", "Other", {"ablation.part_materials=false"}, "posterior"}};
  suite.comparison = {"other", "full"};
  suite.required = {"seconds"};
  suite.cases = {make_case("one", false), make_case("two", true)};
  return suite;
}

}  // namespace

TEST_CASE("suite: a result that failed, is damaged or is missing is a failure, never left out") {
  const TemporaryFolder folder;
  const std::string root = folder.path();
  write_file(root + "/results/one/full/result.tsv", "done\tposterior\t2.50\n");
  write_file(root + "/results/one/other/result.tsv", "failed\tit diverged\n");
  write_file(root + "/results/two/full/result.tsv", "done\tposterior\n");
  const Json json = tables::collect_evaluation(make_suite(), root, {});
  REQUIRE(json.at("cases").size() == 2);
  const Json& one = json.at("cases")[0].at("results");
  CHECK(one.at("full").at("status") == "done");
  CHECK(one.at("full").at("seconds") == 2.5);
  CHECK(one.at("full").at("video") == "one/full/videos/posterior.mp4");
  CHECK(one.at("full").at("metrics") == Json::array({"results/one/full/motion-a.json"}));
  CHECK(one.at("other") == Json({{"status", "failed"}, {"reason", "it diverged"}}));
  const Json& two = json.at("cases")[1];
  CHECK(two.at("objects") == Json::array({"a", "b"}));
  CHECK(two.at("results").at("full").at("reason") == "result.tsv is damaged");
  CHECK(two.at("results").at("other").at("reason") == "no result");
}

TEST_CASE("suite: the makefile names the chosen cases only, and an unknown one is refused") {
  const std::string text = tables::suite_makefile(make_suite(), {"two"});
  CHECK(text.find("SUITE_CASES := two\n") != std::string::npos);
  CHECK(text.find("SUITE_METHODS := full other\n") != std::string::npos);
  CHECK(text.find("SUITE_OBJECTS_two := a b\n") != std::string::npos);
  CHECK(text.find("SUITE_CANDIDATE_other := posterior\n") != std::string::npos);
  CHECK_THROWS_AS(tables::suite_makefile(make_suite(), {"three"}), Error);
}

TEST_CASE("one material: all rows of an object take the material of its largest row") {
  Inventory inventory;
  inventory.objects.resize(2);
  inventory.objects[0].id = "a";
  inventory.objects[1].id = "b";
  Evidence evidence;
  for (const char* object : {"a", "a", "b"}) {
    InventoryRow row;
    row.object = object;
    row.part = "part" + std::to_string(inventory.rows.size());
    inventory.rows.push_back(row);
    EvidenceRow own;
    own.key = row.key();
    own.label = static_cast<int>(inventory.rows.size());
    evidence.rows.push_back(own);
  }
  candidate::give_one_material(evidence, inventory, {1, 2, 5});
  CHECK(evidence.rows[0].label == 2);
  CHECK(evidence.rows[0].key == "a/part0");
  CHECK(evidence.rows[1].label == 2);
  CHECK(evidence.rows[2].label == 3);

  candidate::Configuration configuration;
  for (int r = 0; r < 3; ++r) {
    CandidateRow row;
    row.row = r;
    row.E = r == 2 ? 1e9 : 1e5;
    configuration.rows.push_back(row);
  }
  CHECK(candidate::has_one_material(inventory, configuration));
  candidate::bound_stiffness(configuration);
  CHECK(configuration.rows[2].E == 1e7);
  CHECK(configuration.rows[0].E == 1e5);
  configuration.rows[1].E = 2e5;
  CHECK_FALSE(candidate::has_one_material(inventory, configuration));
}
