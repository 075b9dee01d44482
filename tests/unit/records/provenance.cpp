// Files by their hashes: records without their run times, and what does not belong together.
#include "records/provenance.h"

#include <doctest/doctest.h>

#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

namespace {

void write_json(const std::string& path, const Json& json) {
  write_file(path, json.dump());
}

// A record that names files of its folder.
void write_record(const std::string& path, const Provenance& provenance) {
  write_json(path, {{"provenance", to_json(provenance, folder_of(path))}});
}

}  // namespace

TEST_CASE("provenance: the hash of a record leaves out its run times and nothing else") {
  const TemporaryFolder folder;
  const std::string a = folder / "a.json", b = folder / "b.json";
  write_json(a, {{"x", 1.5}, {"runtime", {{"seconds", 1.25}}}});
  write_json(b, {{"x", 1.5}, {"runtime", {{"seconds", 7}, {"more", "runtime"}}}});
  bool has_runtime = false;
  const std::string hash = sha256_of_record(a, &has_runtime);
  CHECK(has_runtime);
  CHECK(hash == sha256_of_record(b));
  CHECK(hash == sha256_text("{\n  \"x\": 1.5\n}\n"));
  write_json(b, {{"x", 1.6}, {"runtime", {{"seconds", 1.25}}}});
  CHECK(hash != sha256_of_record(b));
  // One that is further down is no run time of the record; a file without any is its bytes.
  write_json(b, {{"x", {{"runtime", 1}}}});
  CHECK(sha256_of_record(b, &has_runtime) == sha256_file(b));
  CHECK_FALSE(has_runtime);
  write_file(folder / "a.txt", "{\"runtime\": 1}");
  CHECK(sha256_of_record(folder / "a.txt") == sha256_file(folder / "a.txt"));
}

TEST_CASE("provenance: inputs and outputs are compared by their bytes, run times apart") {
  const TemporaryFolder folder;
  const std::string input = folder / "input.json", output = folder / "output.bin", record = folder / "record.json";
  write_json(input, {{"x", 1}, {"runtime", {{"seconds", 1}}}});
  write_file(output, "bytes");
  Provenance provenance;
  provenance.tool = "pm-test";
  provenance.add_input(input);
  provenance.add_output(output);
  write_record(record, provenance);
  require_made_from(record, input, true);
  require_written_with(record, output);
  write_json(input, {{"x", 1}, {"runtime", {{"seconds", 2}}}});
  require_made_from(record, input, true);
  write_json(input, {{"x", 2}, {"runtime", {{"seconds", 2}}}});
  CHECK(message_of([&] { require_made_from(record, input, false); }).find("made from a input.json with SHA-256 ") !=
        std::string::npos);
  write_file(output, "byteS");
  const std::string message = message_of([&] { require_written_with(record, output); });
  CHECK(message.find("/provenance/outputs/0") != std::string::npos);
  CHECK(message.find(sha256_text("bytes")) != std::string::npos);
  CHECK(message.find(sha256_text("byteS")) != std::string::npos);
  write_file(folder / "other.bin", "bytes");
  CHECK(message_of([&] { require_written_with(record, folder / "other.bin"); }).find("no other.bin") !=
        std::string::npos);
  CHECK(message_of([&] { require_written_with(record, folder / "none.bin"); }) != "no error");
}

TEST_CASE("provenance: records of people and of earlier versions name nothing, and what is no provenance is none") {
  const TemporaryFolder folder;
  write_file(folder / "file.bin", "bytes");
  for (const char* text : {"{}", "[]", "{\"provenance\": 3}", "{\"provenance\": {\"inputs\": {\"a\": 1}}}",
                           "{\"provenance\": {\"inputs\": [1, {\"path\": 2, \"sha256\": \"x\"}]}}"}) {
    write_file(folder / "record.json", text);
    const RecordedFiles files = recorded_files(folder / "record.json");
    CHECK(files.inputs.empty());
    CHECK_FALSE(files.names_outputs);
    require_made_from(folder / "record.json", folder / "file.bin", false);
    require_written_with(folder / "record.json", folder / "file.bin");
    CHECK(message_of([&] { require_made_from(folder / "record.json", folder / "file.bin", true); }) != "no error");
  }
}
