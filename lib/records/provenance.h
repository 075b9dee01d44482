// Where an artifact comes from: tool, version, options that shape the result, its inputs by SHA-256, and what was
// written together with it. A stage that reads files which name each other checks that they are the bytes that were
// named.
#ifndef PHYSMAS_RECORDS_PROVENANCE_H
#define PHYSMAS_RECORDS_PROVENANCE_H

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace physmas {

struct Provenance {
  struct Input {
    std::string path;    // as the tool opened it; stored relative to the artifact (see base/file.h, portable_path)
    std::string sha256;  // 64 hexadecimal digits
    bool without_runtime = false;  // of a JSON record without its `runtime`, see sha256_of_record
  };
  std::string tool;                                          // "pm-lift"
  std::vector<std::pair<std::string, std::string>> options;  // only options that change the result
  std::vector<Input> inputs;
  std::vector<Input> outputs;  // files that the tool wrote together with the artifact, before it

  // Hashes the file and appends it. Throws an Error when it cannot be read.
  void add_input(const std::string& path);
  void add_output(const std::string& path);
  // The SHA-256 of an input that was added, by the path given then; empty when there is none.
  std::string sha256_of(const std::string& path) const;
};

// What of a page is its run time stands between these.
inline constexpr std::array<std::string_view, 2> kPageRuntime = {"<!--runtime-->", "<!--/runtime-->"};

// The SHA-256 of a JSON record or a page as it would be without its `runtime`, so that equal inputs give equal hashes;
// of the file itself where it has none or is no JSON object. has_runtime, if given: whether there was one.
std::string sha256_of_record(const std::string& path, bool* has_runtime = nullptr);

// What an artifact's provenance names, with paths as it has them. record: of an HDF5 file, "state". Empty for records
// without provenance, as people author them.
struct RecordedFiles {
  std::vector<Provenance::Input> inputs, outputs;
  bool names_outputs = false;  // artifacts of earlier versions do not
};
RecordedFiles recorded_files(const std::string& path, const std::string& hdf5_record = "");

// Whether a file is the one that was named.
bool is_unchanged(const std::string& path, const Provenance::Input& named);

// Whether `record_path` was made from the bytes that `input_path` holds now, by the SHA-256 hashes in its provenance.
// Throws an Error (exit code 3) that names both hashes when the record lists a file of that name with another hash,
// and, if `must_list`, when it lists no such input at all (authored records have no provenance). hdf5_record: where
// `record_path` is an HDF5 file, its record.
void require_made_from(const std::string& record_path, const std::string& input_path, bool must_list,
                       const std::string& hdf5_record = "");

// Whether `output_path` holds the bytes that were written together with `record_path`. Throws an Error (exit code 3)
// that names both hashes when it does not, or is not there. A record that names no outputs is one of an earlier
// version, or authored, and content with any.
void require_written_with(const std::string& record_path, const std::string& output_path);

// Two records that both name an HDF5 input of the same file name (the state) must name the same bytes. Throws an Error
// (exit code 3) that names both hashes.
void require_same_state(const std::string& record_path, const std::string& other_path);

// A recorded exchange with a model that an artifact rests on (schemas/exchange.json).
struct ExchangeReference {
  std::string name;
  std::string sha256;  // of request and response, without run times
};

// What a scene did not need, and why: an entry of an artifact's `omitted` list.
struct Omission {
  std::string what;
  std::string why;
};

}  // namespace physmas

#endif
