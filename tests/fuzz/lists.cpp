// Texts of lines that are read back. Input: a letter, then 'h' the hashes of a suite, 'r' the result of a case
// (result.tsv), 'l' the log of a run and, after 0x1e, its batch.status.
#include "guard.h"
#include "records/json.h"
#include "scratch.h"
#include "screen/run_table.h"
#include "tables/suite.h"

namespace {

using namespace physmas;

// With one case and one method.
Suite small_suite(const Scratch& scratch) {
  Suite suite;
  suite.path = scratch / "suite.json";
  suite.methods.push_back({"physmas", "PhysMAS", {}, ""});
  suite.comparison = {"physmas"};
  suite.cases.emplace_back();
  suite.cases.back().id = "cake";
  suite.cases.back().objects = {"cake"};
  suite.cases.back().prompt = "it falls";
  suite.cases.back().profiles = {"Foam"};
  suite.hashes = {{"suite.json", std::string(64, 'a')}, {"cake.json", std::string(64, '0')}};
  return suite;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Scratch scratch;
  static const Suite suite = small_suite(scratch);
  if (size < 1) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  guard([&] {
    if (data[0] == 'h') {
      scratch.write("suite.sha256", text);
      require_registered(suite);
    } else if (data[0] == 'r') {
      std::filesystem::create_directories(scratch / "results/cake/physmas");
      scratch.write("results/cake/physmas/result.tsv", text);
      tables::collect_evaluation(suite, scratch.folder(), {});
    } else if (data[0] == 'l') {
      const size_t cut = text.find('\x1e');
      scratch.write("log.txt", text.substr(0, cut));
      scratch.write("batch.status", cut == std::string::npos ? "" : text.substr(cut + 1));
      screen::run_table({screen::summarise_run(scratch.folder())});
    }
  });
  return 0;
}
