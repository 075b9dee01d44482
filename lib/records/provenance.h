// Where an artifact comes from: tool, version, options that shape the result, and its inputs by SHA-256.
#ifndef PHYSMAS_RECORDS_PROVENANCE_H
#define PHYSMAS_RECORDS_PROVENANCE_H

#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace physmas {

struct Provenance {
  struct Input {
    std::string path;    // as the tool opened it; stored relative to the artifact (see base/file.h, portable_path)
    std::string sha256;  // 64 hexadecimal digits
  };
  std::string tool;                                          // "pm-lift"
  std::vector<std::pair<std::string, std::string>> options;  // only options that change the result
  std::vector<Input> inputs;

  // Hashes the file and appends it. Throws an Error when it cannot be read.
  void add_input(const std::string& path);
  // The SHA-256 of an input that was added, by the path given then; empty when there is none.
  std::string sha256_of(const std::string& path) const;
};

// Whether `record_path` was made from the bytes that `input_path` holds now, by the SHA-256 hashes in its provenance.
// Throws an Error (exit code 3) that names both hashes when the record lists a file of that name with another hash,
// and, if `must_list`, when it lists no such input at all (authored records have no provenance).
void require_made_from(const std::string& record_path, const std::string& input_path, bool must_list);

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
